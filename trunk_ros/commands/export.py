"""``export``: write what was found into a simulator's own file."""

from __future__ import annotations

from pathlib import Path

from trunk_ros.console.arguments import Parser
from trunk_ros.errors import ArgumentError

FORMATS = ("mjcf", "urdf", "sdf")


def main(argv: list[str]) -> int:
    """Parse, write, say."""
    asked = parser().parse_args(argv)
    from trunk_ros.bodies.found import load_bodies
    from trunk_ros.export.run import bodies_beside, export, say, simulation_beside
    from trunk_ros.model import load_model, save_model
    from trunk_ros.recording.output import new_file, prepare_output

    output, into = Path(asked.output), Path(asked.into)
    layer = output.with_name(f"{output.stem}.reality.yaml")
    for path in (output, layer):
        prepare_output(path, asked.overwrite)
    if not into.is_file():
        raise ArgumentError(f"{into}: no such file: --into wants the simulator's own file")
    simulation = simulation_beside(asked.model, asked.simulation)
    bodies = bodies_beside(asked.model, asked.bodies)
    read = [into, *map(Path, filter(None, (asked.model, simulation, bodies)))]
    if any(new.exists() and old.exists() and new.samefile(old) for new in (output, layer) for old in read):
        raise ArgumentError(f"{output}: would be written over what is read: give --output another name")
    theirs = None if simulation is None else load_model(simulation)
    fitted = None if bodies is None else load_bodies(bodies)
    sheet = export(load_model(asked.model), asked.to, into, theirs, fitted)
    with new_file(output, asked.overwrite) as path:
        path.write_text(sheet.text, encoding="utf-8")
    if sheet.layer.effects:
        with new_file(layer, asked.overwrite) as path:
            save_model(sheet.layer, path)
    elif layer.is_file():
        layer.unlink()
    say(sheet, output, layer, simulation, bodies)
    if into.resolve().parent != output.resolve().parent:
        print(f"  meshes and other files are named from the folder of {into}: put {output} there")
    return 0


def parser() -> Parser:
    """The command's arguments."""
    out = Parser(
        "export",
        "Write what was found into a simulator's own file.",
        ["verdict/model.yaml --to mjcf --into arm.xml -o arm_real.xml"],
    )
    add = out.add_argument
    add("model", metavar="MODEL.yaml", help="what diagnose has written")
    add("--to", required=True, choices=FORMATS, help="the format of FILE")
    add("--into", required=True, metavar="FILE", help="the simulator's file, which stays as it is")
    add("--output", required=True, metavar="FILE", help="the file to write")
    add(
        "--simulation", metavar="SIMULATION.yaml",
        help="what the simulator does already; by default simulation.yaml beside the model, if it is there",
    )  # fmt: skip
    add(
        "--bodies", metavar="BODIES.yaml",
        help="what the command bodies has written; by default bodies.yaml beside the model, if it is there",
    )  # fmt: skip
    add("--overwrite", action="store_true", help="replace what is there")
    return out
