"""What the arm stage found, in the words of ``diagnosis.json``."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.arm_stage import UNITS, ArmFit, ArmProblem
from trunk_ros.diagnosis.arm_values import SHIFT, Key
from trunk_ros.diagnosis.evidence import likely
from trunk_ros.diagnosis.findings import ARM, SURE, UNNAMED_SURE, statement_of, unchanged, value_of
from trunk_ros.diagnosis.leftover import accounted
from trunk_ros.diagnosis.result import Finding
from trunk_ros.effects import effect

UNKNOWN = "unknown"
FRAMES = "the poses may be in another frame, or of another point than the tip"
Losses = dict[str, float]


def arm_findings(problem: ArmProblem, done: ArmFit) -> list[Finding]:
    """Findings of the arm stage: what the model does not have already."""
    out = []
    for name in dict.fromkeys(name for name, _ in done.values):
        mine = [k for k in sorted(done.values) if k[0] == name and not _is_known(problem, done, k)]
        if mine:
            out.append(_shifted(problem, done, mine) if name == SHIFT else _named(problem, done, mine))
    return out


def _is_known(problem: ArmProblem, done: ArmFit, key: Key) -> bool:
    told = value_of(done.values[key], done.std[key], "")
    return key in problem.known and unchanged(told, problem.known[key])


def _named(problem: ArmProblem, done: ArmFit, mine: list[Key]) -> Finding:
    kind, joints = effect(mine[0][0]), problem.arm.joints
    p, named = kind.parameters[0], [joints[c] for _, c in mine if c >= 0]
    parameters = {
        (joints[k[1]] if k[1] >= 0 else ARM): {p.name: value_of(done.values[k], done.std[k], p.unit)}
        for k in mine
    }
    rivals, elsewhere = _rivals(problem, done, mine), _elsewhere(problem, done, mine)
    said = [statement_of(kind, ", ".join(named) or "the arm", parameters)]
    said += [f"The model has {problem.known[k]:.4g} {p.unit}." for k in mine if k in problem.known]
    told = {UNKNOWN: rivals[SHIFT]} if SHIFT in rivals else {}
    told |= {rival: loss for rival, loss in rivals.items() if rival != SHIFT}
    near = sorted((loss, rival) for rival, loss in told.items() if loss < problem.need)
    if rivals.get(SHIFT, np.inf) < problem.need:
        said.append(f"A constant shift would look the same: {FRAMES}.")
    same = [joint for joint, loss in elsewhere.items() if loss < problem.need]
    said += [f"On {' or '.join(same)} it would look the same."] if same else []
    return Finding(
        kind.id, "arm", named, kind.regime,
        _confidence(problem, done, mine, [*rivals.values(), *elsewhere.values()]),
        [rival for _, rival in near], parameters, [], " ".join(said),
        _evidence(problem, done, mine, told, kind.signature),
    )  # fmt: skip


def _shifted(problem: ArmProblem, done: ArmFit, mine: list[Key]) -> Finding:
    """A constant is neither a length nor a tilt, and no model holds it."""
    signals = [problem.signals[k] for _, k in mine]
    values = {s: value_of(done.values[k], done.std[k], UNITS[s]) for s, k in zip(signals, mine, strict=True)}
    rivals = _rivals(problem, done, mine)
    near = sorted((loss, rival) for rival, loss in rivals.items() if loss < problem.need)
    said = ", ".join(f"{s} by {v['value']:.4g} {v['unit']}" for s, v in values.items())
    return Finding(
        UNKNOWN, "arm", [], "always", _confidence(problem, done, mine, list(rivals.values())),
        [rival for _, rival in near], {ARM: values}, [],
        f"The tip is off by a constant, {said}: {FRAMES}. No model holds that.",
        _evidence(problem, done, mine, rivals, "The tip is off by the same in every posture."),
    )  # fmt: skip


def _rivals(problem: ArmProblem, done: ArmFit, mine: list[Key]) -> Losses:
    """What is lost where all that another name can do stands in the place of some values."""
    others, cost = [k for k in done.values if k not in mine], problem.solve(list(done.values))[2]
    names = dict.fromkeys(name for name, _ in problem.candidates if name != mine[0][0])
    trials = {n: [k for k in problem.candidates if k[0] == n and k not in others] for n in names}
    return {n: problem.solve([*others, *keys])[2] - cost for n, keys in trials.items() if keys}


def _elsewhere(problem: ArmProblem, done: ArmFit, mine: list[Key]) -> Losses:
    """What is lost where another joint has one of these values, by joint."""
    cost = problem.solve(list(done.values))[2]
    out: Losses = {}
    for key in mine:
        others = [k for k in done.values if k != key]
        free = [k for k in problem.candidates if k[0] == key[0] and k not in done.values]
        for k in free:
            loss, joint = problem.solve([*others, k])[2] - cost, problem.arm.joints[k[1]]
            out[joint] = min(loss, out.get(joint, np.inf))
    return out


def _confidence(problem: ArmProblem, done: ArmFit, mine: list[Key], losses: list[float]) -> float:
    """As in the wires; less where no value is well above its spread."""
    sure = likely(problem.need * len(mine), sum(done.gain[k] for k in mine), losses)
    sizes = [abs(done.values[k] - problem.known.get(k, 0.0)) / max(done.std[k], 1e-300) for k in mine]
    return round(min(sure, 1.0 if max(sizes) > SURE else 0.5), 3)


def _evidence(
    problem: ArmProblem, done: ArmFit, mine: list[Key], rivals: Losses, signature: str
) -> dict[str, Any]:
    gain = sum(done.gain[k] for k in mine)
    strength = float(np.sqrt(gain / (len(problem.signals) * problem.count)))
    return {"strength": strength, "gain": {ARM: gain}, "rivals": rivals, "form": "", "signature": signature}


def _varies(problem: ArmProblem, off: Array, angles: Array) -> Array:
    """(joints,) of the power of what is off (n, signals), in units of the noise, what goes with angles (n,
    joints).
    """
    told = [sum(accounted(angle, signal) * signal.var() for signal in off.T) for angle in angles.T]
    return np.array(told)


def unknown_arm_finding(problem: ArmProblem, share: float) -> Finding:
    """The tip is off in a way that neither lengths nor tilt explain: with which link's direction it varies
    most, and on which joints' angles it depends.
    """
    off = np.concatenate(problem.residual(problem.known)) / problem.noise
    theta = np.concatenate([d.theta for d in problem.data])
    told = _varies(problem, off, theta)
    varies = [problem.arm.joints[c] for c in np.argsort(-told, kind="stable")[:2]]
    bent = problem.arm.joints[int(np.argmax(_varies(problem, off, theta.cumsum(axis=1))))]
    said = f"the tip is off in a way that no name fits, most with the direction of the link of {bent}"
    said += f" and the angle of {' and '.join(varies)}"
    return Finding(
        effect=UNKNOWN,
        stage="arm",
        joints=[bent],
        regime="posture",
        confidence=UNNAMED_SURE,
        equivalents=[],
        parameters={},
        depends_on=["position", *varies],
        statement=f"{said}; {share:.0%} of it is left by lengths and tilt.",
        evidence={
            "strength": float(np.sqrt(np.mean(off**2))),
            "gain": {},
            "rivals": {},
            "form": "",
            "signature": "The tip is not where the joints put it.",
        },
    )
