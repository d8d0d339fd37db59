"""What a simulator lacks of a model: the model less what the simulator does itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from trunk_ros.arm_model import AnyModel, ArmModel
from trunk_ros.compiled import Array
from trunk_ros.effect_values import Values
from trunk_ros.effects import Effect, effect
from trunk_ros.transmission import ratio_of

PLAY = ("backlash", "tension_error", "narrow_band")
EXCESS = "{}: the simulator has more of it than the arm ({}), which nothing that is added takes away"
CHANGED = "{}: the simulator has it with other values, and one cannot be had from the other"


@dataclass(frozen=True)
class Missing(Generic[AnyModel]):
    """``model``: an arm with the simulator's ratios and no play of its own, with what is to be added;
    ``remarks``: what cannot be added, a sentence each.
    """

    model: AnyModel
    remarks: tuple[str, ...] = ()


def missing(model: AnyModel, simulation: ArmModel | None = None) -> Missing[AnyModel]:
    """What a simulator lacks of the arm as it was at the end; by default it is ideal, with the nominal ratios
    and nothing else.

    Raises ModelError where the two models have different joints.
    """
    model, joints = model.at_end(), model.arm.joints
    theirs = (ArmModel(replace(model.arm, dead_band=0.0 * model.arm.dead_band)) if simulation is None
              else simulation.for_joints(joints).only(joints))  # fmt: skip
    remarks: list[str] = []
    effects: dict[str, Values] = {}
    relative = ratio_of(model) / ratio_of(theirs) - 1.0
    if np.any(relative != 0.0):
        effects["ratio_error"] = {"relative": relative}
    wider = play_of(model) - play_of(theirs)
    if np.any(wider > 0.0):
        effects["backlash"] = {"half_width": np.maximum(wider, 0.0)}
    if np.any(wider < -1e-9):
        remarks.append(EXCESS.format("backlash", listed(joints, -np.minimum(wider, 0.0), "rad")))
    for name, values in model.in_order():
        if name not in (*PLAY, "ratio_error"):
            added = _less(effect(name), joints, values, theirs.effects.get(name), remarks)
            if added:
                effects[name] = added
    for name in theirs.effects:
        if name not in model.effects and name not in (*PLAY, "ratio_error", "servo_delay"):
            remarks.append(EXCESS.format(name, "the arm has none"))
    servo = replace(theirs, arm=model.arm)
    there = replace(theirs.arm, delay=0.0, feedforward=0.0) if simulation is None else theirs.arm
    late = np.maximum(model.number("delay"), 0.0) - replace(theirs, arm=there).number("delay")
    if np.any(late < -1e-9):
        remarks.append(EXCESS.format("servo_delay", listed(joints, -np.minimum(late, 0.0), "s")))
    found = np.asarray(effects.get("servo_delay", {}).get("delay", 0.0))
    beside = late - found
    if np.any(np.minimum(beside, found) < -1e-9):  # no simulator is early by itself
        effects.pop("servo_delay", None)
        beside = late
    arm = replace(
        model.arm,
        ratio=ratio_of(theirs),
        dead_band=0.0 * wider,
        wire=None,
        kp=servo.number("kp"),
        tau_v=servo.number("tau_v"),
        delay=np.maximum(beside, 0.0),
        feedforward=np.maximum(model.arm.feedforward - there.feedforward, 0.0),
    )
    return Missing(replace(model, arm=arm, effects=effects), tuple(remarks))


def play_of(model: ArmModel) -> Array:
    """(joints,) rad: half-width of the play, with what was found."""
    factor = model.effects.get("tension_error", {}).get("factor", 1.0)
    added = model.effects.get("backlash", {}).get("half_width", 0.0)
    less = model.effects.get("narrow_band", {}).get("less", 0.0)
    return np.asarray(np.maximum(model.arm.dead_band * (factor - less) + added, 0.0))


def _less(
    kind: type[Effect], joints: tuple[str, ...], values: Values, theirs: Values | None, remarks: list[str]
) -> Values:
    """An effect's values less those that the simulator has; empty where nothing is left."""
    if theirs is None:
        return values
    form = str(values.get("form", kind.forms[0]))
    lead = kind.own_parameters(form)[0]
    mine, own = (np.asarray(v.get(lead.name, lead.null), dtype=float) for v in (values, theirs))
    if np.allclose(mine, own, rtol=1e-3, atol=1e-9):
        return {}
    if lead.null != 0.0 or lead.scale == "log" or not kind.scalable or not kind.named:
        remarks.append(CHANGED.format(kind.id))
        return {}
    if lead.shared and own.ndim:
        apart = {p.name for p in kind.own_parameters(kind.apart)} if kind.apart else set()
        if not {p.name for p in kind.own_parameters(form)} <= apart:
            remarks.append(CHANGED.format(kind.id))
            return {}
        values, lead = {**values, "form": kind.apart}, kind.own_parameters(kind.apart)[0]
    left = (1.0 + mine) / (1.0 + own) - 1.0 if lead.relative else mine - own
    if lead.bounds[0] == 0.0 and np.any(left < 0.0):
        remarks.append(EXCESS.format(kind.id, listed(joints, -np.minimum(left, 0.0), lead.unit)))
        left = np.maximum(left, 0.0)
    if not np.any(left):
        return {}
    return {**values, lead.name: float(left) if lead.shared else left}


def listed(joints: tuple[str, ...], sizes: Array, unit: str) -> str:
    """Joints and sizes that are not 0, as text."""
    if np.ndim(sizes) == 0:
        return f"{float(sizes):.4g} {unit}"
    return ", ".join(f"{j} {v:.4g} {unit}" for j, v in zip(joints, sizes, strict=True) if v)
