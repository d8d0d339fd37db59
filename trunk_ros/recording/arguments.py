"""The parser of the commands, at its former place."""

from trunk_ros.commands.arguments import Parser

__all__ = ["Parser"]
