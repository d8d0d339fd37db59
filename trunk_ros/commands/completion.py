"""What a shell is told at once, whatever a command imports when it runs: its help, and completion by
``eval "$(register-python-argcomplete trunk_ros)"``.
"""

from __future__ import annotations

import argparse
import importlib
import os
from collections.abc import Callable, Mapping

from trunk_ros.nodes.parameters import PARAMETERS
from trunk_ros.nodes.usage import usage

PARSERS = {"bringup": "trunk_ros.nodes.run.arguments", "replay": "trunk_ros.nodes.bags.replay_arguments"}


def complete(commands: Mapping[str, tuple[str, str]]) -> None:
    """Answer the shell and exit, where argcomplete is installed; only the command asked for is imported."""
    try:
        import argcomplete
    except ImportError:
        return
    argcomplete.autocomplete(whole_parser(commands, os.environ.get("COMP_LINE", "").split()[1:]))


def parser_of(name: str, module: str) -> Callable[[], argparse.ArgumentParser] | None:
    """What makes a command's parser, imported without the command where that takes long; None: has none."""
    if name in PARAMETERS:  # ROS reads a node's arguments
        return None
    return getattr(importlib.import_module(PARSERS.get(name, module)), "parser", None)


def quick_help(name: str) -> str:
    """The help of a command that takes long to import; "" of the others, which give it themselves."""
    if name in PARSERS and (parser := parser_of(name, "")):
        return parser().format_help().rstrip()
    return usage(name) if name in PARAMETERS else ""


def whole_parser(commands: Mapping[str, tuple[str, str]], words: list[str]) -> argparse.ArgumentParser:
    """A parser of all commands; the one that ``words`` begin with has its arguments."""
    parser = argparse.ArgumentParser(prog="trunk_ros")
    parser.add_argument("--version", action="store_true")
    each = parser.add_subparsers()
    for name, (module, what) in commands.items():
        own = parser_of(name, module) if words[:1] == [name] else None
        each.add_parser(name, help=what, parents=[own()] if own else [], add_help=own is None)
    return parser
