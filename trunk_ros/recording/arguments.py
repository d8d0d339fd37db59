"""A parser whose complaints are one line, like all others."""

import argparse
from argparse import ArgumentTypeError
from typing import NoReturn

from trunk_ros.errors import ArgumentError

SETTLE = 5.0  # s


class Parser(argparse.ArgumentParser):
    """Raises ArgumentError where argparse would print the usage and exit."""

    def error(self, message: str) -> NoReturn:
        raise ArgumentError(f"{self.prog}: {message} (--help shows how)")


def add_settle(parser: Parser) -> None:
    """``--settle``, with what is done with it in its help."""
    parser.add_argument(
        "--settle",
        type=_seconds,
        default=SETTLE,
        metavar="S",
        help="seconds of measured joint angles that tell how the wires lay at the start "
        f"(default {SETTLE:g}; 0: none, memory starts at its centre)",
    )


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.0 <= value < float("inf"):
        raise ArgumentTypeError(f"{text} is no length of time: give seconds, 0 or more")
    return value
