"""``evaluate``: score models, or other simulators, on recordings."""

from __future__ import annotations

import argparse
import json
import sys

from trunk_ros.console.arguments import Parser, add_namespace
from trunk_ros.errors import ArgumentError

STAGES = ("servo", "wire", "arm")
WIDE = 160  # columns of a table that goes into a file


def main(argv: list[str]) -> int:
    """Parse, score, say. Returns 3 where an error is above ``--fail-above``."""
    asked = parser().parse_args(argv)
    if not asked.model and not asked.against:
        raise ArgumentError("evaluate: nothing to score: give --model MODEL.yaml or --against SIM_BAG")
    from rich.console import Console

    from trunk_ros.evaluate.run import compared_with, evaluated, verdict
    from trunk_ros.evaluate.score import to_json
    from trunk_ros.evaluate.table import save_csv, show
    from trunk_ros.recording.output import new_file, prepare_output

    if asked.csv:
        prepare_output(asked.csv, asked.overwrite)
    rows = evaluated(asked)
    if asked.csv:
        with new_file(asked.csv, asked.overwrite) as path:
            save_csv(rows, path)
    if asked.json:
        print(json.dumps(to_json(rows), indent=1))
    else:
        show(rows, Console(width=None if sys.stdout.isatty() else WIDE, highlight=False))
    return verdict(rows, asked.fail_above, compared_with(asked.bag, asked.against))


def parser() -> Parser:
    """The command's arguments."""
    out = Parser(
        "evaluate",
        "Score models, or other simulators, on recordings.",
        [
            "run2 -m verdict/model.yaml",
            "run2 -m trunk verdict/model.yaml --csv errors.csv",
            "run2 --against sim2",
        ],
    )
    add = out.add_argument
    add("bag", nargs="+", metavar="BAG", help="recordings: bag folders, .mcap, .db3, .bag")
    add(
        "--model", nargs="+", action="extend", default=[], metavar="MODEL.yaml",
        help="files, or trunk or direct; before: the model's arm without effects",
    )  # fmt: skip
    add(
        "--against", nargs="+", action="extend", default=[], metavar="SIM_BAG",
        help="a simulator's recordings of the same motions, one for each BAG; before: the first simulator",
    )  # fmt: skip
    add_namespace(out)
    add("--stage", nargs="+", action="extend", choices=STAGES, help="only these; all by default")
    add("--settle", type=seconds, default=5.0, metavar="S",
        help="s at the start that do not count, at most a quarter of a recording (default 5)")  # fmt: skip
    add("--json", action="store_true", help="the rows as JSON in place of the table")
    add("--csv", metavar="FILE", help="write the rows")
    add(
        "--fail-above", type=number, metavar="X",
        help="exit with 3 where an rms error is above X times noise; of several simulators the first, "
        "which the others are compared with, does not count",
    )  # fmt: skip
    add("--overwrite", action="store_true", help="replace what is there")
    return out


def seconds(text: str) -> float:
    """A time of 0 or more."""
    value = number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is below 0 s")
    return value


def number(text: str) -> float:
    """A finite number."""
    value = float(text)
    if not abs(value) < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number")
    return value
