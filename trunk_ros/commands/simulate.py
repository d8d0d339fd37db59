"""``simulate``: run a model over a recording."""

from __future__ import annotations

from pathlib import Path

from trunk_ros import __version__
from trunk_ros.console.arguments import Parser, add_namespace, add_settle
from trunk_ros.console.console import say
from trunk_ros.recording.topics import SOURCES


def parser() -> Parser:
    """Arguments of ``simulate``."""
    made = Parser(
        "simulate",
        "Run a model over a recording: the bag OUT_BAG holds the predicted joint_states.",
        ["run2 -m verdict/model.yaml -o predicted", "run2 -m trunk --from setpoints -o nominal"],
    )
    made.add_argument("bag", metavar="BAG", help="recording whose motion is simulated")
    made.add_argument("--model", required=True, metavar="MODEL.yaml", help="a file, or trunk or direct")
    made.add_argument("--output", required=True, metavar="OUT_BAG", help="the folder to write")
    made.add_argument(
        "--from", dest="source", choices=SOURCES, default="gearbox_states",
        help="what drives the model; from setpoints the gearbox is predicted too (default: gearbox_states)",
    )  # fmt: skip
    add_namespace(made)
    add_settle(made)
    made.add_argument("--overwrite", action="store_true", help="replace OUT_BAG if it exists")
    return made


def main(argv: list[str]) -> int:
    """The command."""
    asked = parser().parse_args(argv)
    from trunk_ros.data.put_right import said_of
    from trunk_ros.data.quality import strangers
    from trunk_ros.data.sensing import turns_counted_on
    from trunk_ros.data.sensor_faults import without_wild
    from trunk_ros.evaluate.speeds import too_slow
    from trunk_ros.model import load_model
    from trunk_ros.own_time import doubtful_curves
    from trunk_ros.recording.output import prepare_output
    from trunk_ros.recording.read import read_recording
    from trunk_ros.recording.write import write_recording
    from trunk_ros.simulate import simulate
    from trunk_ros.transmission import by_joint

    prepare_output(asked.output, asked.overwrite)
    model = load_model(asked.model)
    recording = turns_counted_on(without_wild(read_recording(asked.bag, namespace=asked.namespace)))
    say(*(f"{asked.bag}: {note}" for note in said_of(recording)))
    say(*(f"{asked.bag}: {note}" for note in strangers(by_joint(recording, model.arm), model)))
    say(*(f"{asked.bag}: {note}" for note in doubtful_curves(recording, model)))
    if asked.source == "setpoints":
        say(*(f"{asked.bag}: {note}" for note in too_slow(recording, model)))
    predicted = simulate(recording, model, asked.source, asked.settle)
    settled = str(asked.settle if "joint_states" in recording.series else 0.0)
    custom = {
        "trunk_ros": __version__, "model": model.hash(), "from": asked.source, "settle": settled,
    }  # fmt: skip
    write_recording(Path(asked.output), predicted, overwrite=asked.overwrite, custom=custom)
    said = predicted.series["joint_states"]
    say(f"{asked.output}: {len(said.stamp)} predictions of {', '.join(said.joints)}")
    return 0
