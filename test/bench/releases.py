"""The benches that are kept, one per release."""

from __future__ import annotations

from pathlib import Path

from trunk_ros import __version__

FOLDER = Path(__file__).parent / "releases"


def kept(version: str = __version__) -> Path:
    """Where the bench of a version is kept."""
    return FOLDER / f"{version}.json"


def last(folder: Path = FOLDER, version: str = __version__) -> Path | None:
    """The kept bench of the newest version before this one; None if there is none."""
    earlier = [path for path in folder.glob("*.json") if numbers(path.stem) < numbers(version)]
    return max(earlier, key=lambda path: numbers(path.stem), default=None)


def numbers(version: str) -> tuple[int, ...]:
    """A version in an order: 0.10.0 comes after 0.2.0."""
    return tuple(map(int, version.split(".")))
