"""A parser whose complaints are one line, like all others."""

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn

from trunk_ros.errors import ArgumentError
from trunk_ros.recording import allowance


class Parser(argparse.ArgumentParser):
    """Raises ArgumentError where argparse would print the usage and exit.

    Every command has the option that lifts the bounds on what files may become.
    """

    def __init__(self, *given: Any, **options: Any) -> None:
        super().__init__(*given, **options)
        self.add_argument(allowance.OPTION, action=_Lift, nargs=0, help=allowance.HELP)

    def error(self, message: str) -> NoReturn:
        raise ArgumentError(f"{self.prog}: {message} (--help shows how)")


class _Lift(argparse.Action):
    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        allowance.lift()
