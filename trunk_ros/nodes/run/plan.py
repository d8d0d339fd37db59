"""What a bringup is asked to do, checked before anything starts."""

from __future__ import annotations

import argparse
import json
import platform
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros import __version__
from trunk_ros.errors import ArgumentError
from trunk_ros.model import Model, load_model
from trunk_ros.motion import NAMES, named_trajectory
from trunk_ros.nodes.control.follower import check_rest, limits_of
from trunk_ros.nodes.run.arguments import PARTS, parser
from trunk_ros.recording.output import BAG_FILES, prepare_output
from trunk_ros.trajectory import Trajectory, TrajectoryError, load_trajectory

BELIEVES = {"servo_driver": "plant", "wire_elasticity": "plant", "compensator": "model"}
PUBLISHED = {"servo_driver": "trunk/gearbox_states", "wire_elasticity": "joint_states"}


@dataclass(frozen=True)
class Plan:
    """A checked request. ``models``: what each node believes the arm to be."""

    parts: tuple[str, ...]
    output: Path | None
    overwrite: bool
    seconds: float
    rate: float
    simulated: bool
    apart: bool
    models: dict[str, Model]
    trajectory: Trajectory | None
    ros_arguments: list[str]
    manifest: str

    @property
    def arm(self) -> Any:
        """The arm that is moved."""
        return next(iter(self.models.values())).arm

    def parameters(self, part: str) -> dict[str, Any]:
        """Parameters of one of the nodes."""
        common: dict[str, Any] = {"rate": self.rate, "supervised": True, "use_sim_time": self.simulated}
        if part == "recorder":
            return common | {"output": str(self.output), "manifest": self.manifest}
        if part == "wire_elasticity":
            common["tf"] = True
        return common | self.models[part].parameters()


def plan_of(argv: Sequence[str]) -> Plan:
    """Parse and check. Raises TrunkError in one line."""
    own, ros = split_ros(list(argv))
    given = parser().parse_args(own)
    if not 0 < given.seconds < float("inf"):
        raise ArgumentError(f"--seconds {given.seconds:g}: give a time above 0")
    if not 1 <= given.rate <= 2000:
        raise ArgumentError(f"--rate {given.rate:g}: give 1 to 2000 Hz")
    parts = tuple(part for part in PARTS if part not in chosen(given.without))
    trajectory, models = motion(given)
    return Plan(
        parts,
        output_of(given) if "recorder" in parts else None,
        given.overwrite,
        given.seconds,
        given.rate,
        given.sim_time,
        given.processes,
        models,
        trajectory if "compensator" in parts else None,
        ros,
        manifest(argv, given, models),
    )


def split_ros(argv: list[str]) -> tuple[list[str], list[str]]:
    """Our arguments, and those from --ros-args on."""
    if "--ros-args" not in argv:
        return argv, []
    start = argv.index("--ros-args")
    end = argv.index("--", start) if "--" in argv[start:] else len(argv)
    return argv[:start] + argv[end + 1 :], argv[start:end]


def chosen(without: Sequence[str]) -> set[str]:
    """The nodes to leave out. Raises ArgumentError for one that there is not."""
    names = {name for each in without for name in each.split(",") if name}
    for name in sorted(names):
        if name not in PARTS:
            raise ArgumentError(f"--without {name}: choose from {', '.join(PARTS)}")
    return names


def output_of(given: argparse.Namespace) -> Path:
    """The bag's folder. Raises ArgumentError where it cannot be written."""
    if not given.output:
        raise ArgumentError("give --output BAG, or --without recorder")
    path = prepare_output(given.output, given.overwrite, BAG_FILES)
    existing = next(parent for parent in path.absolute().parents if parent.exists())
    probe = existing / f".{path.name}.probe"
    try:
        probe.mkdir()
        probe.rmdir()
    except OSError as error:
        raise ArgumentError(f"{path} cannot be written: {error.strerror}") from None
    return path


def motion(given: argparse.Namespace) -> tuple[Trajectory, dict[str, Model]]:
    """The trajectory, and the model of each node. Raises TrunkError where they do not go together."""
    believed = load_model(given.model or "trunk")
    plant = load_model(given.plant_model) if given.plant_model else None
    from_file = load_trajectory(given.trajectory) if is_file(given.trajectory) else None
    plant = plant or Model(believed.arm)
    if from_file is not None:
        believed, plant = (bound(model, from_file.joints) for model in (believed, plant))
    for model in (believed, plant):
        if model.any_joints:
            raise ArgumentError("a model for any joints needs a trajectory FILE that names them")
    if believed.arm.joints != plant.arm.joints:
        raise ArgumentError(
            f"--model has joints {', '.join(believed.arm.joints)}, "
            f"--plant-model {', '.join(plant.arm.joints)}"
        )
    trajectory = from_file or named_trajectory(given.trajectory, believed.arm, given.seconds)
    try:
        check(trajectory, believed)
    except TrajectoryError as error:
        other = not given.model and not set(trajectory.joints) <= set(believed.arm.joints)
        which = "; --model MODEL.yaml says which arm it is, trunk by default" if other else ""
        raise TrajectoryError(f"--trajectory {given.trajectory}: {error}{which}") from None
    return trajectory, {part: believed if side == "model" else plant for part, side in BELIEVES.items()}


def bound(model: Model, joints: tuple[str, ...]) -> Model:
    """A model for any joints becomes one for these."""
    return model.for_joints(joints) if model.any_joints else model


def is_file(name: str) -> bool:
    """Whether a trajectory is a file rather than a name."""
    return name not in NAMES and (
        Path(name).suffix in (".yaml", ".yml") or Path(name).exists() or "/" in name
    )


def check(trajectory: Trajectory, model: Model) -> None:
    """Raise TrajectoryError where the motion, begun where the arm rests, breaks a limit."""
    arm = model.arm
    still = np.zeros(len(arm.joints))
    motion = trajectory.for_joints(arm.joints, arm.rest).after(arm.rest, still, still)
    motion.check(limits_of(arm, np.inf))
    check_rest(motion)


def manifest(argv: Sequence[str], given: argparse.Namespace, models: dict[str, Model]) -> str:
    """What made the recording, as JSON for the bag."""
    return json.dumps(
        {
            "command": shlex.join(["bringup", *argv]),
            "version": __version__,
            "python": platform.python_version(),
            "trajectory": given.trajectory,
            "models": {part: model.hash() for part, model in models.items()},
            "parameters": {part: model.parameters() for part, model in models.items()},
        }
    )
