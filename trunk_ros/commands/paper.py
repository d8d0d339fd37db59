"""``paper``: the source of the nominal arm, checked number by number."""

from __future__ import annotations

from pathlib import Path

from trunk_ros.console.arguments import Parser


def parser() -> Parser:
    """Arguments of ``paper``."""
    made = Parser("paper", "The paper's numbers, checked, and its further work.", ["", "-o paper"])
    made.add_argument(
        "--output", type=Path, metavar="DIR", help="also write a page with figures into this folder"
    )
    made.add_argument("--overwrite", action="store_true", help="replace DIR if it exists")
    return made


def main(argv: list[str]) -> int:
    """``paper [--output DIR] [--overwrite]``."""
    asked = parser().parse_args(argv)
    from trunk_ros.paper.command import run

    run(asked.output, asked.overwrite)
    return 0
