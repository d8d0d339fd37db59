"""A parser with the manners that all commands share: short options, examples, one-line complaints."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from trunk_ros.console.console import Level, ask_for
from trunk_ros.errors import ArgumentError
from trunk_ros.recording import allowance

SHORT = {"--output": "-o", "--model": "-m"}
PROGRAM = "trunk_ros"
SETTLE = 5.0  # s, as start.SETTLE, which is slow to import


class Parser(argparse.ArgumentParser):
    """Raises ArgumentError where argparse would print the usage and exit.

    ``--output`` and ``--model`` have their short forms in every command, and every command takes -q and -v.
    """

    def __init__(self, prog: str, description: str, examples: Sequence[str] = (), **others: Any) -> None:
        """``examples``: arguments after the command's name that the help shows, each as one types it."""
        super().__init__(
            prog=f"{PROGRAM} {prog}",
            description=description,
            epilog="\n".join(["examples:", *(f"  {PROGRAM} {prog} {one}" for one in examples)])
            if examples
            else None,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            **others,
        )
        self.name = prog
        spoken = self.add_mutually_exclusive_group()
        spoken.add_argument("-q", "--quiet", action="store_true", help="say nothing but errors")
        spoken.add_argument("-v", "--verbose", action="store_true", help="say each step, with its time")
        self.add_argument(allowance.OPTION, action=_Lift, nargs=0, help=allowance.HELP)

    def add_argument(self, *flags: Any, **settings: Any) -> argparse.Action:
        """As in argparse; the well-known options get their short forms."""
        short = [SHORT[flag] for flag in flags if flag in SHORT and SHORT[flag] not in flags]
        return super().add_argument(*short, *flags, **settings)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As in argparse, and from here on as much is said as was asked for."""
        args = list(sys.argv[1:] if args is None else args)
        self._refuse_unknown(args)
        parsed = super().parse_args(args, namespace)
        ask_for(Level.QUIET if parsed.quiet else Level.VERBOSE if parsed.verbose else Level.NORMAL)
        return parsed

    def _refuse_unknown(self, args: Sequence[str]) -> None:
        """Name an option that there is not before argparse asks for those that are missing."""
        for arg in args:
            if arg == "--":
                return
            option = arg.partition("=")[0]
            if option.startswith("--") and not any(o.startswith(option) for o in self._option_string_actions):
                self.error(f"no option {option}{did_you_mean(option, self._option_string_actions)}")

    def error(self, message: str) -> NoReturn:
        raise ArgumentError(f"{self.name}: {message} (--help shows how)")


class _Lift(argparse.Action):
    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        allowance.lift()


def did_you_mean(word: str, known: Any) -> str:
    """A question to put behind a complaint, "" where nothing is near."""
    near = get_close_matches(word, list(known), 1)
    return f": did you mean {near[0]}?" if near else ""


def add_settle(parser: Parser) -> None:
    """``--settle``, for the commands that estimate how a recording began."""
    parser.add_argument(
        "--settle", type=_seconds, default=SETTLE, metavar="S",
        help="seconds of measured joint angles that tell how the wires lay at the start "
        f"(default {SETTLE:g}; 0: none, memory starts at its centre)",
    )  # fmt: skip


def add_namespace(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """``--namespace``, for the commands that read the bag of one arm."""
    parser.add_argument(
        "--namespace", metavar="NS", help="of the arm, such as /left, where a bag holds several"
    )


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is no length of time: give seconds, 0 or more")
    return value


def count(text: str) -> int:
    """A number of cores or processes."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: give a whole number from 1 on")
    return int(text)
