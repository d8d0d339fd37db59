"""Files on this machine and behind URLs, by one interface (fsspec): found, told apart, brought here."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any

from trunk_ros.errors import ArgumentError

METADATA = "metadata.yaml"
FILES = (".mcap", ".db3", ".bag")
BLOCK = 1 << 20  # bytes


def is_url(path: str) -> bool:
    """Whether a path is behind a protocol such as s3://."""
    return "://" in path


def file_system(path: str) -> tuple[Any, str]:
    """The file system of a path or URL, and the path in it.

    Raises ArgumentError where the protocol's package is missing.
    """
    import fsspec

    try:
        system, place = fsspec.core.url_to_fs(path if is_url(path) else str(Path(path).absolute()))
    except (ImportError, ValueError) as error:
        raise ArgumentError(f"{path}: {error}") from None
    return system, str(place)


def fingerprint(path: str) -> str:
    """What tells the content of a recording: a hash of its bytes, behind a URL what the store says of them.

    Raises OSError where there is nothing to read.
    """
    system, place = file_system(path)
    if not system.exists(place):
        raise FileNotFoundError("does not exist")
    names = sorted(system.find(place)) if system.isdir(place) else [place]
    digest = hashlib.sha256()
    for name in names:
        digest.update(str(PurePosixPath(name).relative_to(PurePosixPath(place))).encode())
        if is_url(path):
            digest.update(str(system.ukey(name)).encode())
        else:
            _add(digest, name)
    return digest.hexdigest()[:32]


def _add(digest: Any, name: str) -> None:
    with open(name, "rb") as stream:
        while block := stream.read(BLOCK):
            digest.update(block)


@contextmanager
def here(path: str) -> Iterator[Path]:
    """A recording as files on this machine: itself, or a copy for as long as it is needed.

    Raises OSError where it cannot be fetched.
    """
    if not is_url(path):
        yield Path(path)
        return
    system, place = file_system(path)
    with tempfile.TemporaryDirectory(prefix="trunk_ros_") as folder:
        copy = Path(folder, PurePosixPath(place.rstrip("/")).name)
        system.get(place, str(copy), recursive=system.isdir(place))
        yield copy
