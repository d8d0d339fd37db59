"""What a simulator lacks of a model, written into its own file."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from trunk_ros.bodies.found import Bodies
from trunk_ros.errors import ModelError
from trunk_ros.export.mjcf import MjcfWriter
from trunk_ros.export.sdf import SdfWriter
from trunk_ros.export.sheet import Sheet, Writer, sheet_of
from trunk_ros.export.urdf import UrdfWriter
from trunk_ros.model import Model

FORMATS: dict[str, type[Writer]] = {"mjcf": MjcfWriter, "urdf": UrdfWriter, "sdf": SdfWriter}
SIMULATION, BODIES = "simulation.yaml", "bodies.yaml"


def export(
    model: Model, to: str, into: Path, simulation: Model | None = None, bodies: Bodies | None = None
) -> Sheet:
    """Write what a simulator lacks of a model into its own file.

    ``to``: one of FORMATS; ``simulation``: what it does already, by default nothing; ``bodies``: friction,
    armature and the last link, where torque has shown them. Raises TrunkError where the file cannot be read,
    or the model names no joints.
    """
    if model.any_joints:
        raise ModelError("export wants a model with joints: one that diagnose has written")
    if bodies is not None and (other := set(bodies.joints) - set(model.arm.joints)):
        raise ModelError(f"the bodies are of another arm: the model has no joint {', '.join(sorted(other))}")
    return sheet_of(model, simulation, partial(FORMATS[to], path=into), bodies)  # type: ignore[call-arg]


def simulation_beside(model: str, given: str | None) -> str | None:
    """What the simulator does already: as given, or the file that ``diagnose --against`` wrote beside."""
    beside = Path(model).with_name(SIMULATION)
    return given or (str(beside) if beside.is_file() else None)


def bodies_beside(model: str, given: str | None) -> str | None:
    """What ``bodies`` has written: as given, or the file beside the model."""
    beside = Path(model).with_name(BODIES)
    return given or (str(beside) if beside.is_file() else None)


def say(sheet: Sheet, output: Path, layer: Path, simulation: str | None, bodies: str | None) -> None:
    """What was written, what is left, and what cannot be had."""
    count = f"{len(sheet.lines)} change{'' if len(sheet.lines) == 1 else 's'}"
    print(f"{output}: {count}; what your simulator had already: {simulation or 'its ratios only'}")
    if bodies:
        print(f"  friction, armature and last link from {bodies}")
    for line in sheet.lines:
        print(f"  {line.name}: {line.text}")
    if sheet.layer.effects:
        print(f"{layer}: what this format cannot say, for the reality layer and the node reality")
        for sentence in sheet.left:
            print(f"  {sentence}")
    for remark in sheet.remarks:
        print(f"  note: {remark}")
