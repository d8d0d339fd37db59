"""Completion in a shell: ``eval "$(register-python-argcomplete trunk_ros)"``."""

from __future__ import annotations

import argparse
import importlib
import os
from collections.abc import Mapping


def complete(commands: Mapping[str, tuple[str, str]]) -> None:
    """Answer the shell and exit, where argcomplete is installed; only the command asked for is imported."""
    try:
        import argcomplete
    except ImportError:
        return
    argcomplete.autocomplete(whole_parser(commands, os.environ.get("COMP_LINE", "").split()[1:]))


def whole_parser(commands: Mapping[str, tuple[str, str]], words: list[str]) -> argparse.ArgumentParser:
    """A parser of all commands; the one that ``words`` begin with has its arguments."""
    parser = argparse.ArgumentParser(prog="trunk_ros")
    parser.add_argument("--version", action="store_true")
    each = parser.add_subparsers()
    for name, (module, what) in commands.items():
        own = getattr(importlib.import_module(module), "parser", None) if words[:1] == [name] else None
        each.add_parser(name, help=what, parents=[own()] if own else [], add_help=own is None)
    return parser
