"""What can be diagnosed from a recording, before anything is fitted: stages, joints, and effects that its
motion can show.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from trunk_ros.data.align import hidden_by_gaps, servo_span, wire_span
from trunk_ros.data.motion_content import STANDS, top_speed
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.jumps import turns_of
from trunk_ros.diagnosis.evidence.at_rest import honest
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.search.candidates import DYNAMIC, usable, what_it_has
from trunk_ros.diagnosis.search.fit import costed
from trunk_ros.diagnosis.search.formed import with_ratios
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.verdict.answer import STAGES
from trunk_ros.effects import Effect, registry
from trunk_ros.errors import TrunkError
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import COMPARED, TIP, TOPICS

LACKS = {
    "load": "the load is unknown: give masses in the model, or record effort",
    "weight": "the model has no masses",
    "effort": "what the motors pull was not recorded",
    "dead_band": "the model has no nominal backlash",
    "several": "there is one joint only",
}
RARE = "the recording stops and measures, or always moves alike: it shows nothing of speed and holds"
ONE_WAY = "no joint turns back: the recording shows nothing of reversals, holds and time"
HOLDS = "no joint turns back: the recording shows nothing of reversals and of what drifts"
HIDDEN = "the motion of no joint can show it"


@dataclass
class Prospect:
    """Of one stage. ``missing``: why it cannot be diagnosed, "" where it can.

    ``joints``: those that can be judged, with the noise [rad] of their readings; ``silent``: those that
    hardly move. ``unseen``: effects that are not looked for, by the reason.
    """

    stage: str
    missing: str = ""
    joints: dict[str, float] = field(default_factory=dict)
    silent: list[str] = field(default_factory=list)
    effects: list[str] = field(default_factory=list)
    unseen: dict[str, list[str]] = field(default_factory=dict)


def prospects(recording: Recording, model: Model) -> list[Prospect]:
    """For each stage in the order of the signal."""
    return [_prospect(recording, model, stage) for stage in STAGES]


def _prospect(recording: Recording, model: Model, stage: str) -> Prospect:
    there = {*recording.series, *([TIP] if recording.tip is not None else [])}
    lacking = [TOPICS[key] for key in COMPARED[stage] if key not in there]
    if lacking:
        return Prospect(stage, f"no {' and no '.join(lacking)} in the recording")
    if stage == "arm":
        return _arm(recording, model)
    try:
        span = (servo_span if stage == "servo" else wire_span)(recording, model)
        made = (ServoStage if stage == "servo" else WireStage)([span], model, recording.units)
        context = first_look(made)
    except TrunkError as error:
        return Prospect(stage, str(error))
    right = with_ratios(costed(context, context.known)) if stage == "wire" else context.known
    noise = honest(context if right is context.known else context.weighed(right), right).noise
    judged = {context.joints[c]: noise[c].std for c in context.columns}
    silent = [joint for joint in context.joints if joint not in judged]
    if not judged:
        hidden = hidden_by_gaps(recording) if stage == "servo" else ""
        return Prospect(stage, hidden or "no joint moves enough", silent=silent)
    seen = [kind.id for kind in usable(context)]
    return Prospect(stage, "", judged, silent, seen, _unseen(context, seen))


def _unseen(context: Context, seen: list[str]) -> dict[str, list[str]]:
    """The stage's other effects, by the reason why they are not looked for."""
    out: dict[str, list[str]] = {}
    for name, kind in registry().items():
        if kind.stage == context.stage.name and kind.named and kind.tried and name not in seen:
            out.setdefault(_reason(context, kind), []).append(name)
    return out


def _reason(context: Context, kind: type[Effect]) -> str:
    if set(context.columns) <= context.stage.one_way and all(
        kind.regime in context.motion(c).untold for c in context.columns
    ):
        return HOLDS if context.stage.holding else ONE_WAY
    if kind.regime in DYNAMIC and not context.speed_tells:
        return RARE
    has = what_it_has(context)
    return next((LACKS[need] for need in kind.needs if not has[need]), HIDDEN)


def _arm(recording: Recording, model: Model) -> Prospect:
    arm = model.for_joints(recording.joints).arm if model.any_joints else model.arm
    if not arm.has_geometry:
        return Prospect("arm", "the model has neither link lengths nor a URDF")
    if missing := [joint for joint in arm.joints if joint not in recording.joints]:
        return Prospect("arm", f"joint_states lacks {', '.join(missing)} of the model")
    effects = [name for name, kind in registry().items() if kind.stage == "arm" and kind.named]
    return Prospect("arm", "", dict.fromkeys(arm.joints, float("nan")), [], effects)


def motion_of(recording: Recording) -> dict[str, dict[str, float]]:
    """Least and largest angle [rad], top speed [rad/s] and turns of each joint, by joint."""
    keys = [key for key in ("joint_states", "gearbox_states") if key in recording.series]
    series = recording.series[keys[0]] if keys else None
    if series is None:
        return {}
    out = {}
    for joint, column in zip(series.joints, series.position.T, strict=True):
        known = np.isfinite(column)
        if known.any():
            out[joint] = _motion(series.stamp[known], column[known])
    return out


def _motion(stamp: np.ndarray, angle: np.ndarray) -> dict[str, float]:
    """Of one joint, (n,) each."""
    return {
        "low": float(angle.min()),
        "high": float(angle.max()),
        "speed": top_speed(stamp, angle[:, None]),
        "turns": len(turns_of(angle, max(float(np.ptp(angle)) / 20.0, STANDS))),
    }
