"""What there is to see of a recording and a model: angles, residuals, findings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.report.regimes import MEANING, stretches
from trunk_ros.diagnosis.report.units import spoken
from trunk_ros.errors import RecordingError
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate


@dataclass(frozen=True)
class Spell:
    """One finding on one joint, and when [s] its regime holds; none: throughout."""

    effect: str
    joint: str
    regime: str
    spans: list[tuple[float, float]]


@dataclass(frozen=True)
class Scene:
    """Angles (n, joints) at ``stamp`` (n,) s, in rad, or m where a joint slides; NaN where one is lost."""

    joints: tuple[str, ...]
    units: dict[str, str]
    stamp: Array
    measured: Array
    nominal: Array
    fitted: Array
    spells: list[Spell]
    statement: str
    """What was found, as Markdown."""


def scene(recording: Recording, model: Model, diagnosis: Mapping[str, Any] | None = None) -> Scene:
    """Measured joints beside those of a model and of the same model without its effects.

    ``diagnosis``: the content of a diagnosis.json. Raises RecordingError where joint_states are missing.
    """
    measured = recording.require("joint_states")
    nominal, fitted = (
        simulate(recording, m).series["joint_states"] for m in (replace(model, effects={}), model)
    )
    joints = fitted.joints
    seen = measured.select(joints)
    rows = np.searchsorted(seen.stamp, fitted.stamp)
    if not len(rows):
        raise RecordingError(f"{recording.name}: joint_states and gearbox_states do not overlap in time")
    angles = seen.position[np.minimum(rows, len(seen.stamp) - 1)]
    spells = _spells(diagnosis or {}, joints, fitted.stamp, fitted.position)
    units = {joint: recording.units.get(joint, "rad") for joint in joints}
    said = _statement(diagnosis or {}, model)
    return Scene(joints, units, fitted.stamp, angles, nominal.position, fitted.position, spells, said)


def diagnosis_beside(model: str | Path) -> dict[str, Any] | None:
    """What was found when a model was written, where diagnosis.json lies beside it."""
    path = Path(model).parent / "diagnosis.json"
    if not Path(model).is_file() or not path.is_file():
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):  # the arm can be shown without it
        return None
    return content if isinstance(content, dict) and isinstance(content.get("findings"), list) else None


def _spells(
    diagnosis: Mapping[str, Any], joints: tuple[str, ...], stamp: Array, angles: Array
) -> list[Spell]:
    return [
        Spell(spoken(str(found["effect"])), joint, str(found["regime"]), _spans(found, stamp, angles[:, c]))
        for found in diagnosis.get("findings", ())
        for c, joint in enumerate(joints)
        if found["stage"] != "arm" and (not found["joints"] or joint in found["joints"])
    ]


def _spans(found: Mapping[str, Any], stamp: Array, angle: Array) -> list[tuple[float, float]]:
    return stretches(stamp, angle, str(found["regime"])) if found["regime"] in MEANING else []


def _statement(diagnosis: Mapping[str, Any], model: Model) -> str:
    found = [
        f"- **{spoken(str(one['effect']))}** ({one['confidence']:.0%}): {one['statement']}"
        for one in diagnosis.get("findings", ())
    ]
    rest = [f"- unexplained: {one['statement']}" for one in diagnosis.get("unexplained", ())]
    effects = [f"- {spoken(name)}" for name in model.effects]
    if diagnosis:
        return "\n".join([f"# {spoken(str(diagnosis.get('verdict', '')))}", *found, *rest])
    return "\n".join(["# Effects of the model", *(effects or ["none: nominal and fitted are the same"])])
