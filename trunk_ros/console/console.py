"""What commands say: as much as was asked for by ``-q`` and ``-v``."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from enum import IntEnum


class Level(IntEnum):
    """How much is said besides errors."""

    QUIET = 0
    NORMAL = 1
    VERBOSE = 2


class _Asked:
    """The level of the command that runs."""

    level = Level.NORMAL


def ask_for(level: Level) -> None:
    """Set how much is said from here on."""
    _Asked.level = level


def asked() -> Level:
    """How much is to be said."""
    return _Asked.level


def say(*lines: str) -> None:
    """Print lines on the standard output, unless the command was asked to be quiet."""
    if asked() > Level.QUIET:
        for line in lines:
            print(line)


def warn(line: str) -> None:
    """Print a line on the standard error, unless the command was asked to be quiet."""
    if asked() > Level.QUIET:
        print(f"trunk_ros: {line}", file=sys.stderr, flush=True)


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows as lines whose columns are aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
