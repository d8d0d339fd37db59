"""``recover``: a bag whose recorder was killed becomes one that all readers open."""

from __future__ import annotations

from pathlib import Path

from trunk_ros.console.arguments import Parser
from trunk_ros.console.console import say


def parser() -> Parser:
    """Arguments of ``recover``."""
    made = Parser(
        "recover", "Repair a bag in place whose recorder was killed, and say what was lost.", ["run1"]
    )
    made.add_argument("bag", metavar="BAG", type=Path, help="a rosbag2 folder, or an .mcap file")
    return made


def main(argv: list[str]) -> int:
    """The command."""
    asked = parser().parse_args(argv)
    from trunk_ros.recording.recover import recover

    say(*recover(asked.bag))
    return 0
