"""How much a file may become in memory or in the temporary folder: small files that unpack without end."""

import os
from pathlib import Path

from trunk_ros.errors import RecordingError

OPTION = "--any-size"
HELP = "read what unpacks to more than 100 times its size, too: for files that you trust"
VARIABLE = "TRUNK_ROS_ANY_SIZE"  # in the environment, so that it also holds for nodes and worker processes
FLOOR = 64 << 20  # bytes that any file may become
GROWTH = 100  # times its size on disk; recordings of arms that stand still become 30 times theirs


def lift() -> None:
    """Take away all bounds, in this process and in those that it starts from now on."""
    os.environ[VARIABLE] = "1"


def is_lifted() -> bool:
    """Whether whoever runs this trusts the files."""
    return os.environ.get(VARIABLE, "") not in ("", "0")


class Allowance:
    """Bytes that the files of a recording may be unpacked to, all together."""

    def __init__(self, path: Path) -> None:
        """path: a file, or a folder whose files count."""
        self.path = path
        files = path.iterdir() if path.is_dir() else [path]
        self.total = FLOOR + GROWTH * sum(file.stat().st_size for file in files if file.is_file())
        self.left = self.total

    def take(self, size: int) -> None:
        """Count bytes that are about to be unpacked. RecordingError where that is too much."""
        self.left -= size
        if self.left < 0 and not is_lifted():
            raise self._error()

    def check(self, size: int) -> None:
        """The same for bytes that are needed for a moment only: they are not counted."""
        if size > self.total and not is_lifted():
            raise self._error()

    @property
    def most(self) -> int:
        """Bytes to unpack at once at most: one more than is allowed, so that too much shows."""
        return (1 << 40) if is_lifted() else max(self.left, 0) + 1

    def _error(self) -> RecordingError:
        return RecordingError(
            f"{self.path}: unpacks to more than {self.total / 1e6:.0f} MB ({GROWTH} times its size on disk "
            f"and {FLOOR >> 20} MiB): give {OPTION} if it is meant to"
        )
