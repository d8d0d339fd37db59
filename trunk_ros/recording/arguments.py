"""A parser whose complaints are one line, like all others."""

import argparse
from typing import NoReturn

from trunk_ros.errors import ArgumentError


class Parser(argparse.ArgumentParser):
    """Raises ArgumentError where argparse would print the usage and exit."""

    def error(self, message: str) -> NoReturn:
        raise ArgumentError(f"{self.prog}: {message} (--help shows how)")
