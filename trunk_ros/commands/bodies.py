"""``bodies``: friction, armature and the last link's mass from the torque of the motors."""

from __future__ import annotations

import argparse
import json
import sys

from trunk_ros.console.arguments import Parser, add_namespace
from trunk_ros.console.console import say

WIDE = 160  # columns of a table that goes into a file


def main(argv: list[str]) -> int:
    """Parse, fit, write, say."""
    asked = parser().parse_args(argv)
    from trunk_ros.model import load_model
    from trunk_ros.recording.output import new_file, prepare_output
    from trunk_ros.recording.read import read_recording

    prepare_output(asked.output, asked.overwrite)
    model = load_model(asked.model)
    recordings = [read_recording(bag, namespace=asked.namespace) for bag in asked.bag]
    from rich.console import Console

    from trunk_ros.bodies.found import save_bodies
    from trunk_ros.bodies.run import bodies_of, show

    found = bodies_of(recordings, model, asked.cutoff)
    with new_file(asked.output, asked.overwrite) as path:
        save_bodies(found, path)
    if asked.json:
        print(json.dumps(found.to_json(), indent=1))
    elif not asked.quiet:
        show(found, Console(width=None if sys.stdout.isatty() else WIDE, highlight=False))
        say(f"{asked.output}: `trunk_ros export` takes it from beside the model")
    return 0


def parser() -> Parser:
    """The command's arguments."""
    out = Parser(
        "bodies",
        "Fit friction, damping and armature of each joint, mass and centre of the last link, to the motors' "
        "torque\n(effort on gearbox_states, over the ratio).",
        [
            "run1 -m verdict/model.yaml -o verdict/bodies.yaml",
            "run1 run2 -m my-arm.yaml -o bodies.yaml --cutoff 8",
        ],
    )
    add = out.add_argument
    add("bag", nargs="+", metavar="BAG", help="recordings of one arm: bag folders, .mcap, .db3, .bag")
    add("--model", required=True, metavar="MODEL.yaml", help="the arm with the masses of its links")
    add("--output", required=True, metavar="BODIES.yaml", help="the file to write")
    add(
        "--cutoff", type=frequency, metavar="HZ",
        help="motion that is faster is left out (default: 5 times the frequency below which 95 %% of the "
        "speed's power lies)",
    )  # fmt: skip
    add_namespace(out)
    add("--json", action="store_true", help="the same as JSON in place of the table")
    add("--overwrite", action="store_true", help="replace what is there")
    return out


def frequency(text: str) -> float:
    """A finite number above 0."""
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is no frequency above 0 Hz")
    return value
