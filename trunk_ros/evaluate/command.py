"""``evaluate``: the command."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from trunk_ros.errors import ArgumentError
from trunk_ros.evaluate.score import SETTLE, Row, score, to_json
from trunk_ros.evaluate.source import of_model, of_simulator
from trunk_ros.evaluate.table import save_csv, show
from trunk_ros.model import load_model
from trunk_ros.recording.arguments import Parser
from trunk_ros.recording.output import new_file, prepare_output
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording

FAILED = 3
STAGES = ("servo", "wire", "arm")
WIDE = 160  # columns of a table that goes into a file


def main(argv: list[str]) -> int:
    """Parse, score, say. Returns 3 where an error is above ``--fail-above``."""
    arguments = parser().parse_args(argv)
    if not arguments.model and not arguments.against:
        raise ArgumentError("evaluate: nothing to score: give --model MODEL.yaml or --against SIM_BAG")
    if arguments.csv:
        prepare_output(arguments.csv, arguments.overwrite)
    rows = evaluated(arguments)
    if arguments.csv:
        with new_file(arguments.csv, arguments.overwrite) as path:
            save_csv(rows, path)
    if arguments.json:
        print(json.dumps(to_json(rows), indent=1))
    else:
        show(rows, Console(width=None if sys.stdout.isatty() else WIDE, highlight=False))
    return verdict(rows, arguments.fail_above)


def evaluated(arguments: argparse.Namespace) -> list[Row]:
    """All rows, recording by recording. Raises TrunkError in one line."""
    models = [(name, load_model(name)) for name in arguments.model]
    rows: list[Row] = []
    names = called(arguments.bag)
    with Console(stderr=True).status("reading") as status:
        shared = shared_out(arguments.bag, arguments.against)
        for bag, called_so, simulators in zip(arguments.bag, names, shared, strict=True):
            status.update(f"{bag}")
            recording = read_recording(bag)
            predictions = [of_model(recording, name, model) for name, model in models]
            read: list[Recording] = [read_recording(path) for path in simulators]
            predictions += [
                of_simulator(recording, str(path), one, read[0])
                for path, one in zip(simulators, read, strict=True)
            ]
            rows += score(called_so, predictions, arguments.settle)
    kept = [row for row in rows if row.stage in (arguments.stage or STAGES)]
    if not kept:
        raise ArgumentError("evaluate: none of the recordings has a signal of these stages to compare")
    return kept


def called(bags: Sequence[str]) -> list[str]:
    """What the bags are called: the names of their folders or files, whole paths where these are the same."""
    short = [Path(bag).name for bag in bags]
    return [bag if short.count(name) > 1 else name for bag, name in zip(bags, short, strict=True)]


def shared_out(bags: Sequence[str], simulators: Sequence[str]) -> list[list[str]]:
    """The simulator's recordings of each bag's motion: one after the other, as the bags are given."""
    if len(simulators) % len(bags):
        raise ArgumentError(
            f"evaluate: {len(bags)} recordings and {len(simulators)} of --against: give each simulator's "
            "recordings of the same motions, in the same order"
        )
    return [list(simulators[k :: len(bags)]) for k in range(len(bags))]


def verdict(rows: Sequence[Row], most: float | None) -> int:
    """3, and a line on stderr, where an rms error is more than ``most`` times the noise."""
    above = [row for row in rows if most is not None and not row.in_noise <= most]
    if not above:
        return 0
    worst = max(above, key=lambda row: row.in_noise)
    print(
        f"trunk_ros: {len(above)} of {len(rows)} signals err by more than {most:g} times the noise, "
        f"most of all {worst.stage} {worst.joint} of {worst.recording} ({worst.model}): {worst.in_noise:.2f}",
        file=sys.stderr,
    )
    return FAILED


def parser() -> Parser:
    """The command's arguments."""
    out = Parser("evaluate", description="Score models, or other simulators, on recordings.")
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
    add("--stage", nargs="+", action="extend", choices=STAGES, help="only these; all by default")
    add("--settle", type=seconds, default=SETTLE, metavar="S",
        help="s at the start that do not count, at most a quarter of a recording (default 5)")  # fmt: skip
    add("--json", action="store_true", help="the rows as JSON in place of the table")
    add("--csv", metavar="FILE", help="write the rows")
    add(
        "--fail-above", type=number, metavar="X", help="exit with 3 where an rms error is above X times noise"
    )
    add("--overwrite", action="store_true")
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
