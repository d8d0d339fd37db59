"""What the plots hold, by signal, and what each finding does to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trunk_ros.chain import Chain
from trunk_ros.compiled import Array, compiled
from trunk_ros.diagnosis.verdict.answer import STAGES, Answer
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effects import effect
from trunk_ros.errors import TrunkError
from trunk_ros.levels import ROUGH
from trunk_ros.recording.signal.measured import Measured

CELLS = 300  # of time that a picture has: in each the extremes of every curve are kept


@dataclass(frozen=True)
class Signal(Measured):
    """With what was predicted before and after: arrays (n,), in ``unit``; gearbox and its velocity in rad,
    rad/s. They are made of what the plots hold when they are asked for: of a long recording that is much.
    """

    valid: np.ndarray
    noise: float
    held: dict[str, Any]

    @property
    def before(self) -> Array:
        """(n,) the nominal prediction."""
        return np.asarray(self.measured - self._all("error_before"))

    @property
    def after(self) -> Array:
        """(n,) the prediction with all that was found."""
        return np.asarray(self.measured - self._all("error_after"))

    @property
    def gearbox(self) -> Array | None:
        """(n,) rad; None at the tip."""
        return None if self.held.get("gearbox") is None else self._all("gearbox")

    @property
    def velocity(self) -> Array | None:
        """(n,) rad/s of the gearbox; None at the tip."""
        return None if self.held.get("velocity") is None else self._all("velocity")

    @property
    def changed(self) -> bool:
        """Whether anything that was found acts on the signal."""
        return bool(np.any(self.held["error_after"] != self.held["error_before"]))

    @property
    def error_before(self) -> Array:
        """(n,) measured less the nominal prediction, NaN where it does not count."""
        return np.where(self.valid, self._all("error_before"), np.nan)

    @property
    def error_after(self) -> Array:
        """(n,) measured less the prediction with all that was found, NaN where it does not count."""
        return np.where(self.valid, self._all("error_after"), np.nan)

    def _all(self, key: str) -> Array:
        return np.asarray(self.held[key], dtype=float)


def signals(result: Answer) -> list[Signal]:
    """The signals of all stages in the order of the signal path."""
    out = []
    for (stage, name), held in sorted(result.plots.items(), key=lambda item: STAGES.index(item[0][0])):
        said = entries(result, stage).get(name, {})
        valid = np.asarray(held["valid"], dtype=bool) & np.isfinite(held["measured"])
        about = stage, name, str(said.get("unit", "rad"))
        out.append(Signal(*about, held["stamp"], held["measured"], valid, float(held["noise"]), held))
    return out


def entries(result: Answer, stage: str) -> dict[str, dict[str, Any]]:
    """Errors of a stage's signals, by joint or by the tip's coordinate."""
    said = result.stages.get(stage, {})
    return dict(said.get("tip" if stage == "arm" else "joints", {}))


def judged(result: Answer) -> bool:
    """Whether any signal of any stage was compared."""
    return any(entries(result, stage) for stage in STAGES)


def mixed_up(result: Answer) -> dict[str, list[str]]:
    """By stage, what is said of data that are mixed up and were left out for it."""
    out: dict[str, list[str]] = {}
    for held in result.quality.values():
        for one in held.get("mix_ups", ()):
            if one["certain"] and one["statement"] not in (said := out.setdefault(one["stage"], [])):
                said.append(str(one["statement"]))
    return out


def largest(result: Answer, stage: str, unit: str) -> float:
    """Error of the worst of a stage's signals of one unit: all of a column are told in its multiple."""
    every = entries(result, stage).values()
    return max((float(e["rmse_before"] or 0.0) for e in every if e.get("unit", "rad") == unit), default=0.0)


def concerns(finding: Finding, stage: str, name: str) -> bool:
    """Whether a finding acts on a signal: any of the tip's, where the finding is of the arm stage."""
    return finding.stage == stage and (stage == "arm" or not finding.joints or name in finding.joints)


def acts(finding: Finding) -> bool:
    """Whether a finding changes the prediction: physics that no name and no curve fits is in no model."""
    return bool(finding.parameters or finding.curve or finding.evidence.get("strength"))


def contributions(result: Answer, finding: Finding) -> dict[str, Array]:
    """What a finding adds to the prediction of its signals, (n,) by name.

    Alone on a signal, it is all that changed; beside others in the wire, the model with it less the model
    without it; beside others elsewhere, all of them together.
    """
    mine = {s.name: s for s in signals(result) if concerns(finding, s.stage, s.name)}
    alone = {n for n, s in mine.items() if sum(concerns(f, s.stage, n) for f in result.findings) == 1}
    out = {name: s.after - s.before for name, s in mine.items()}
    if finding.stage == "wire" and alone != set(mine):
        out |= {n: y for n, y in _share_in_wire(result, finding).items() if n in mine and n not in alone}
    return out


def _is(finding: Finding, name: str) -> bool:
    """Whether an effect of the model is what a finding is about; curves have several names."""
    return name == finding.effect or not (finding.named or effect(name).named)


def _share_in_wire(result: Answer, finding: Finding) -> dict[str, Array]:
    """By joint; joints that were not judged are taken to stand at zero."""
    model = result.model
    known = {s.name: s for s in signals(result) if s.stage == "wire"}
    stamp = next(iter(known.values())).stamp
    gearbox, velocity = np.zeros((2, len(stamp), len(model.arm.joints)))
    for c, joint in enumerate(model.arm.joints):
        if joint in known:
            gearbox[:, c], velocity[:, c] = known[joint].gearbox, known[joint].velocity
    less = replace(model, effects={k: v for k, v in model.effects.items() if not _is(finding, k)})
    try:
        with_it, without_it = (Chain(m, "wire").run(gearbox, stamp, None, velocity)[0] for m in (model, less))
    except TrunkError:  # a picture is not worth the report
        return {}
    return {joint: with_it[:, c] - without_it[:, c] for c, joint in enumerate(model.arm.joints)}


def joint_angle(result: Answer, signal: Signal) -> Array | None:
    """(n,) rad, where the gearbox puts the joint: ratio times gearbox angle. None for the tip."""
    if signal.gearbox is None or signal.name not in result.model.arm.joints:
        return None
    return np.asarray(signal.gearbox * result.model.arm.ratio[result.model.arm.index(signal.name)])


def load(result: Answer, signal: Signal) -> Array | None:
    """(n,) N m about a signal's joint, with the payload that was found. None where the arm has no masses."""
    arm = result.model.loaded_arm()
    if not arm.has_load or signal.name not in arm.joints:
        return None
    angles = np.zeros((len(signal.stamp), len(arm.joints)))
    for other in signals(result):
        angle = joint_angle(result, other)
        if other.stage == signal.stage and angle is not None:
            angles[:, arm.index(other.name)] = angle
    return arm.load(angles)[:, arm.index(signal.name)]


def reversals(u: Array) -> tuple[Array, Array]:
    """Direction of motion (n,), 1 or -1, and travel (n,) since it last changed, in the unit of ``u``."""
    return _reversals(np.ascontiguousarray(u, dtype=float), ROUGH * float(np.ptp(u)))


@compiled
def _reversals(u: Array, still: float) -> tuple[Array, Array]:
    direction, travel = np.ones(len(u)), np.zeros(len(u))
    sign, farthest, start = 1.0, u[0], u[0]
    for k in range(len(u)):
        if sign * (u[k] - farthest) > 0.0:
            farthest = u[k]
        elif sign * (farthest - u[k]) > still:
            sign, start, farthest = -sign, farthest, u[k]
        direction[k] = sign
        travel[k] = max(sign * (u[k] - start), 0.0)
    return direction, travel
