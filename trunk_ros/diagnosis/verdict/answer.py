"""What a diagnosis says, to programs."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from trunk_ros.diagnosis.verdict.events import Event, events
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.model import Model, save_model
from trunk_ros.recording.topics import COMPARED
from trunk_ros.trajectory import Trajectory, save_trajectory

SCHEMA = "trunk_ros/diagnosis/1"
STAGES = tuple(COMPARED)
NOMINAL = "nominal.yaml"  # the arm without effects, where it is in no other file
FROM_URDF = "robot_description"  # what stood for the model where a recorded URDF did


@dataclass
class Unexplained:
    """What is left after all findings; ``share`` of the misfit's power before."""

    stage: str
    joints: list[str]
    regime: str
    share: float
    depends_on: list[str]
    statement: str


@dataclass(repr=False)
class Answer:
    """All that a diagnosis says. ``stages`` is as in the JSON; ``model`` the nominal model with what was
    found.
    """

    stages: dict[str, dict[str, Any]]
    findings: list[Finding]
    unexplained: list[Unexplained]
    experiments: list[dict[str, Any]]
    model: Model
    quality: dict[str, Any] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)
    plots: dict[tuple[str, str], dict[str, Any]] = field(default_factory=dict)
    """Arrays that the report draws: per stage and signal, stamps, measured, how far that is from what was
    predicted before and after, what counts. Beside the stamps single precision will do for pictures; of
    errors too, as they are kept instead of predictions, whose difference would show steps.
    """
    trajectories: dict[str, Trajectory] = field(default_factory=dict)
    """Motions of the experiments by the names of their files."""
    simulation: dict[str, Any] = field(default_factory=dict)
    """What another simulator was found to do itself, where the arm is compared with one."""
    simulator: Model | None = None
    """The model of that."""

    @property
    def verdict(self) -> str:
        """``no_mismatch``, ``explained``, ``partly_explained`` or ``unexplained``."""
        named = [f for f in self.findings if f.named]
        rest = bool(self.unexplained) or len(named) < len(self.findings)
        if not self.findings and not self.unexplained:
            return "no_mismatch"
        if not rest:
            return "explained"
        return "partly_explained" if named else "unexplained"

    @property
    def described(self) -> bool:
        """Whether a URDF, given or recorded, says what the nominal arm is, which is then in no model file."""
        told = self.provenance
        return "urdf" in told.get("arguments", {}) or told.get("model") == FROM_URDF

    @property
    def files(self) -> list[str]:
        """What ``save`` writes for the experiments: their motions, and what plays them."""
        return [*self.trajectories, *([NOMINAL] if self.trajectories and self.described else [])]

    @property
    def events(self) -> list[Event]:
        """Where findings begin and end within the recording, in the order of time."""
        return events(self.findings)

    def to_json(self) -> dict[str, Any]:
        """The dictionary that ``diagnosis.json`` holds."""
        content = {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "stages": self.stages,
            "findings": [asdict(f) for f in self.findings],
            "unexplained": [asdict(u) for u in self.unexplained],
            "experiments": self.experiments,
            "events": [event.to_json() for event in self.events],
            "quality": self.quality,
            "provenance": self.provenance,
        }
        if self.simulation:
            content["simulation"] = self.simulation
        plain = _plain(content)
        assert isinstance(plain, dict)
        return plain

    def save(self, folder: str | Path) -> None:
        """Write ``diagnosis.json``, ``model.yaml`` and the experiments' trajectories into a folder, which is
        made where it is not there; the arm without effects too, where one of them is played with it.
        """
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "diagnosis.json").write_text(json.dumps(self.to_json(), indent=1, allow_nan=False) + "\n")
        save_model(self.model, folder / "model.yaml")
        if self.simulator is not None:
            save_model(self.simulator, folder / "simulation.yaml")
        if NOMINAL in self.files:
            save_model(Model(self.model.arm), folder / NOMINAL)
        for name, trajectory in self.trajectories.items():
            save_trajectory(folder / name, trajectory)


def _plain(value: Any) -> Any:
    """Numbers of numpy as numbers of JSON; what is not finite as null."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
