"""Outputs that are whole or not there: written beside their place, moved there at the end."""

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from fnmatch import fnmatch
from pathlib import Path

from trunk_ros.errors import ArgumentError

BAG_FILES = ("metadata.yaml", "*.mcap", "*.db3", "*.db3-*", "*.zstd", "*.mcap.damaged")
PAGE = 2**20  # bytes that any output may take


def prepare_output(path: str | Path, overwrite: bool, known: Sequence[str] | None = None) -> Path:
    """The path of an output, checked before the work begins; ArgumentError if it cannot be written there.

    known: patterns of the names that such an output folder holds: one that holds others is never overwritten.
    """
    path = Path(path)
    if path.is_symlink() or path.exists():
        if not overwrite:
            raise ArgumentError(f"{path} exists: give another output, or --overwrite")
        _refuse_foreign(path, known)
    parent = path.absolute().parent
    if path.name in ("", ".."):
        raise ArgumentError(f"{path} cannot be an output: it has no name of its own")
    there = next(each for each in (parent, *parent.parents) if each.exists())
    if not there.is_dir():
        raise ArgumentError(f"{path} cannot be an output: {there} is a file, not a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise ArgumentError(f"{path} cannot be written: {os.strerror(errno.EACCES)} in {there}")
    try:  # permissions do not tell of a full disk, and root is told that it may write anywhere
        with tempfile.TemporaryDirectory(dir=there, prefix=f".{path.name}.") as tried:
            (Path(tried) / "page").write_bytes(bytes(PAGE))
    except OSError as error:
        raise ArgumentError(f"{path} cannot be written: {error.strerror or error} in {there}") from None
    return path


def _refuse_foreign(path: Path, known: Sequence[str] | None) -> None:
    if known is None or not path.is_dir():
        return
    foreign = [each.name for each in path.iterdir() if not any(fnmatch(each.name, one) for one in known)]
    if foreign:
        raise ArgumentError(f"{path} holds other things too ({sorted(foreign)[0]}): it is not overwritten")


@contextmanager
def new_folder(
    path: str | Path, overwrite: bool = False, known: Sequence[str] | None = None
) -> Iterator[Path]:
    """A folder to write into that becomes `path` when the block ends; after an error nothing of it is left.

    What was at `path` is replaced only then. ArgumentError if it cannot be written, as on a full disk.
    """
    path = prepare_output(path, overwrite, known)
    draft = None
    try:
        path.absolute().parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(dir=path.absolute().parent, prefix=f".{path.name}."))
        draft.chmod(0o755)
        yield draft
        for file in draft.rglob("*"):
            if file.is_file():
                _to_disk(file)
        replace_path(draft, path)
    except OSError as error:
        raise ArgumentError(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        if draft is not None:
            shutil.rmtree(draft, ignore_errors=True)


@contextmanager
def new_file(path: str | Path, overwrite: bool = False) -> Iterator[Path]:
    """The same for a single file: write to the path that is given."""
    path = prepare_output(path, overwrite)
    if path.is_dir():
        raise ArgumentError(f"{path} is a folder: give the name of a file")
    draft = path.absolute().with_name(f".{path.name}.{os.getpid()}")
    try:
        draft.parent.mkdir(parents=True, exist_ok=True)
        yield draft
        _to_disk(draft)
        draft.replace(path)
    except OSError as error:
        raise ArgumentError(f"{path} cannot be written: {error.strerror or error}") from None
    finally:
        draft.unlink(missing_ok=True)


def replace_path(new: Path, path: Path) -> None:
    """Move `new` to `path`; what was there is removed once `new` is in its place, or comes back."""
    if not path.is_dir() or path.is_symlink():
        with suppress(FileNotFoundError):
            path.unlink()
        new.rename(path)
        return
    old = Path(tempfile.mkdtemp(dir=path.absolute().parent, prefix=f".{path.name}.old."))
    try:
        path.rename(old / path.name)
        try:
            new.rename(path)
        except OSError:
            (old / path.name).rename(path)
            raise
    finally:
        shutil.rmtree(old, ignore_errors=True)


def _to_disk(file: Path) -> None:
    with file.open("rb") as stream:
        os.fsync(stream.fileno())
