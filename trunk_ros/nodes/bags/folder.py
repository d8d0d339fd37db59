"""The folder of a new bag, and what a recorder that was killed left there."""

from __future__ import annotations

from pathlib import Path

from trunk_ros.errors import ArgumentError, RecordingError
from trunk_ros.recording.recover import recover, unfinished


def create_folder(folder: Path) -> None:
    """Make a bag's folder. One that a killed recorder left there is repaired, and refused as well.

    Raises ArgumentError.
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
    except FileExistsError:
        raise ArgumentError(f"{folder} exists{_repaired(folder)}: give another output") from None
    except OSError as error:
        raise ArgumentError(f"{folder} cannot be written: {error.strerror}") from None


def _repaired(folder: Path) -> str:
    try:
        if not unfinished(folder):
            return ""
        return f", an unfinished recording that has been repaired ({'; '.join(recover(folder))})"
    except RecordingError as error:
        return f" ({str(error).removeprefix(str(folder)).lstrip(': ')})"
