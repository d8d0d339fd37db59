"""Files that come with the package (config/, launch/), in a checkout or installed by pip, colcon or apt."""

from pathlib import Path

from trunk_ros.errors import TrunkError

PACKAGE = "trunk_ros"


def share_folder(module: Path | None = None) -> Path:
    """Folder that holds config/ and launch/, seen from this file or from `module`.

    Next to the package in a checkout, also for an editable install and colcon's --symlink-install; else
    PREFIX/share/trunk_ros, with PREFIX a folder above the package. Raises TrunkError where there is neither.
    """
    package = (module or Path(__file__)).resolve().parent
    source = package.parent
    prefixes = (source, *source.parents)
    for folder in (source, *(prefix / "share" / PACKAGE for prefix in prefixes)):
        if (folder / "package.xml").is_file() and (folder / "config").is_dir():
            return folder
    raise TrunkError(f"no config/ belongs to {package}: install {PACKAGE} again")


def config_names(folder: str = "") -> list[str]:
    """Names in config/, or in a `folder` of it, that `config_path` takes; YAML files without their suffix."""
    config = share_folder() / "config"
    files = sorted(path for path in (config / folder).glob("*") if path.is_file())
    return [path.relative_to(config).as_posix().removesuffix(".yaml") for path in files]


def config_path(name: str) -> Path:
    """The file of a name in config/, such as "trunk". Raises TrunkError that lists the valid names."""
    config = share_folder() / "config"
    for path in (config / f"{name}.yaml", config / name):
        if path.is_file():
            return path
    folder = name.rpartition("/")[0]
    names = config_names(folder) or config_names()
    raise TrunkError(f"config/ has no {name!r}: choose one of {', '.join(names)}")
