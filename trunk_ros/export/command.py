"""``export``: the command."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from trunk_ros.errors import ArgumentError, ModelError
from trunk_ros.export.mjcf import MjcfWriter
from trunk_ros.export.sdf import SdfWriter
from trunk_ros.export.sheet import Sheet, Writer, sheet_of
from trunk_ros.export.urdf import UrdfWriter
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.arguments import Parser
from trunk_ros.recording.output import new_file, prepare_output

FORMATS: dict[str, type[Writer]] = {"mjcf": MjcfWriter, "urdf": UrdfWriter, "sdf": SdfWriter}
SIMULATION = "simulation.yaml"


def main(argv: list[str]) -> int:
    """Parse, write, say."""
    arguments = parser().parse_args(argv)
    output, into = Path(arguments.output), Path(arguments.into)
    layer = output.with_name(f"{output.stem}.reality.yaml")
    for path in (output, layer):
        prepare_output(path, arguments.overwrite)
    if not into.is_file():
        raise ArgumentError(f"{into}: no such file: --into wants the simulator's own file")
    simulation = simulation_beside(arguments.model, arguments.simulation)
    theirs = None if simulation is None else load_model(simulation)
    sheet = export(load_model(arguments.model), arguments.to, into, theirs)
    with new_file(output, arguments.overwrite) as path:
        path.write_text(sheet.text, encoding="utf-8")
    if sheet.layer.effects:
        with new_file(layer, arguments.overwrite) as path:
            save_model(sheet.layer, path)
    elif layer.is_file():
        layer.unlink()
    say(sheet, output, layer, simulation)
    if into.resolve().parent != output.resolve().parent:
        print(f"  meshes and other files are named from the folder of {into}: put {output} there")
    return 0


def export(model: Model, to: str, into: Path, simulation: Model | None = None) -> Sheet:
    """Write what a simulator lacks of a model into its own file.

    ``to``: one of FORMATS; ``simulation``: what it does already, by default nothing. Raises TrunkError where
    the file cannot be read, or the model names no joints.
    """
    if model.any_joints:
        raise ModelError("export wants a model with joints: one that diagnose has written")
    return sheet_of(model, simulation, partial(FORMATS[to], path=into))  # type: ignore[call-arg]


def simulation_beside(model: str, given: str | None) -> str | None:
    """What the simulator does already: as given, or the file that ``diagnose --against`` wrote beside."""
    beside = Path(model).with_name(SIMULATION)
    return given or (str(beside) if beside.is_file() else None)


def say(sheet: Sheet, output: Path, layer: Path, simulation: str | None) -> None:
    """What was written, what is left, and what cannot be had."""
    print(
        f"{output}: {len(sheet.lines)} changes; what it had already: {simulation or 'nothing but its ratios'}"
    )
    for line in sheet.lines:
        print(f"  {line.name}: {line.text}")
    if sheet.layer.effects:
        print(f"{layer}: what this format cannot say, for the reality layer and the node reality")
        for sentence in sheet.left:
            print(f"  {sentence}")
    for remark in sheet.remarks:
        print(f"  note: {remark}")


def parser() -> Parser:
    """The command's arguments."""
    out = Parser("export", description="Write what was found into a simulator's own file.")
    add = out.add_argument
    add("model", metavar="MODEL.yaml", help="what diagnose has written")
    add("--to", required=True, choices=list(FORMATS))
    add("--into", required=True, metavar="FILE", help="the simulator's file, which stays as it is")
    add("--output", required=True, metavar="FILE")
    add(
        "--simulation", metavar="SIMULATION.yaml",
        help=f"what the simulator does already; by default {SIMULATION} beside the model, if it is there",
    )  # fmt: skip
    add("--overwrite", action="store_true")
    return out
