"""Where the text of a URDF comes from: a file, a ROS package, or itself."""

from __future__ import annotations

import os
from pathlib import Path

from trunk_ros.arm.description import tree
from trunk_ros.errors import ModelError

PACKAGE = "package://"
PATHS = (("AMENT_PREFIX_PATH", "share"), ("ROS_PACKAGE_PATH", ""))


def is_text(source: str) -> bool:
    """Whether a source is the URDF itself and no name of it."""
    return source.lstrip().startswith("<")


def urdf_text(source: str, folder: Path | None = None) -> str:
    """The URDF of FILE (from ``folder`` on), package://PACKAGE/FILE or its own text.

    Raises ModelError where it cannot be read, or a file holds none.
    """
    if is_text(source):
        return source
    path = _in_package(source) if source.startswith(PACKAGE) else (folder or Path()) / source
    if path.suffix == ".xacro":
        raise ModelError(f"{path} has xacro macros: write what `xacro {path.name}` makes of it to a file")
    try:
        text = path.read_text(encoding="utf-8")
        tree(text)
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from None
    except (OSError, UnicodeDecodeError) as error:
        said = error.strerror if isinstance(error, OSError) else "it is no text"
        raise ModelError(f"cannot read the URDF {path}: {said}") from None
    return text


def _in_package(source: str) -> Path:
    package, _, file = source.removeprefix(PACKAGE).partition("/")
    for variable, between in PATHS:
        for prefix in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            for folder in (Path(prefix, between, package), Path(prefix)):
                if folder.name == package and (folder / file).is_file():
                    return folder / file
    raise ModelError(f"no {file or 'file'} in a package {package!r}: source the workspace that has it first")
