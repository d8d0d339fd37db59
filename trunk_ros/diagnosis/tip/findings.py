"""What the arm stage found, in the words of ``diagnosis.json``."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import rms
from trunk_ros.diagnosis.evidence.evidence import UNNAMED, likely
from trunk_ros.diagnosis.evidence.residual_dependence import accounted
from trunk_ros.diagnosis.tip.data import UNITS
from trunk_ros.diagnosis.tip.stage import ArmFit, ArmProblem
from trunk_ros.diagnosis.tip.values import NAMELESS, SHIFT, ZERO, Key, of_sensors, owner, parameter_of
from trunk_ros.diagnosis.verdict.finding import UNKNOWN, Finding, evidence_of
from trunk_ros.diagnosis.verdict.findings import ARM, statement_of, unchanged, value_of
from trunk_ros.effects import effect
from trunk_ros.guards import TINY
from trunk_ros.levels import SURE

FRAMES = "a camera's frame, a marker's place or a joint sensor's zero makes one"
EITHER = 0.77  # confidence in a value that may as well be another link's: no equivalent says so
Losses = dict[str, float]


def arm_findings(problem: ArmProblem, done: ArmFit) -> list[Finding]:
    """Findings of the arm stage: what the model does not have already."""
    new = [k for k in sorted(done.values) if not _is_known(problem, done, k)]
    names = dict.fromkeys(owner(k) for k in new if k[0] not in NAMELESS)
    out = [_named(problem, done, [k for k in new if owner(k) == name]) for name in names]
    rest = [k for k in new if k[0] in NAMELESS]
    return [*out, _nameless(problem, done, rest)] if rest else out


def _is_known(problem: ArmProblem, done: ArmFit, key: Key) -> bool:
    told = value_of(done.values[key], done.std[key], "")
    return key in problem.known and unchanged(told, problem.known[key])


def _named(problem: ArmProblem, done: ArmFit, mine: list[Key]) -> Finding:
    kind, joints = effect(owner(mine[0])), problem.arm.joints
    named = list(dict.fromkeys(joints[c] for _, c in mine if c >= 0))
    parameters: dict[str, dict[str, Any]] = {}
    for k in mine:
        p, of = parameter_of(k), joints[k[1]] if k[1] >= 0 else ARM
        unit = problem.arm.units.get(of, p.unit) if p.unit == "rad" else p.unit
        parameters.setdefault(of, {})[p.name] = value_of(done.values[k], done.std[k], unit)
    rivals, elsewhere = _rivals(problem, done, mine), _elsewhere(problem, done, mine)
    said = [statement_of(kind.title(), ", ".join(named) or "the arm", parameters)]
    said += [
        f"The model has {problem.known[k]:.4g} {parameter_of(k).unit}." for k in mine if k in problem.known
    ]
    near, zeros = _near(problem, rivals), of_sensors()
    if UNKNOWN in near:
        said.append(f"A constant error of the readings would look the same: {FRAMES}.")
    same = [joint for joint, loss in elsewhere.items() if loss < problem.need]
    said += [f"On {' or '.join(same)} it would look the same."] if same else []
    if shown := [joints[c] for _, c in mine if c >= 0 and problem.zeros[c] and kind.moves_joints]:
        near = [*zeros, *near]
        said.append(
            f"{', '.join(shown)}: also off against the gearbox, so the sensor's zero may be what is off."
        )
    if kind.everywhere and problem.zeros[0]:
        near += zeros
        said.append(f"A zero error of {joints[0]}'s sensor would look the same.")
    return Finding(
        kind.id, "arm", named, kind.regime,
        _confidence(problem, done, mine, [*rivals.values(), *elsewhere.values()]),
        near, parameters, [], " ".join(said), _evidence(problem, done, mine, rivals, kind.signature),
    )  # fmt: skip


def _nameless(problem: ArmProblem, done: ArmFit, mine: list[Key]) -> Finding:
    """A constant error of readings is neither a length nor a tilt, and no model holds it."""
    values: dict[str, dict[str, Any]] = {}
    said = []
    for name, c in mine:
        owner, what = (ARM, problem.signals[c]) if name == SHIFT else (problem.arm.joints[c], ZERO)
        side = 1.0 if name == SHIFT else -1.0  # what a reading is off by, and not what it lacks
        told = value_of(side * done.values[name, c], done.std[name, c], UNITS.get(what, "rad"))
        values.setdefault(owner, {})[what] = told
        of = f"the tip's {what}" if name == SHIFT else f"the zero of {owner}"
        said.append(f"{of} by {told['value']:.4g} {told['unit']}")
    rivals = _rivals(problem, done, mine)
    zeros = [problem.arm.joints[c] for name, c in mine if name == ZERO]
    return Finding(
        UNKNOWN, "arm", zeros, "always", _confidence(problem, done, mine, list(rivals.values())),
        _near(problem, rivals) + (of_sensors() if zeros else []), values, [],
        f"Readings are off by a constant, {', '.join(said)}: {FRAMES}. No model holds that.",
        _evidence(problem, done, mine, rivals, "The tip is off by the same constants in every posture."),
    )  # fmt: skip


def _near(problem: ArmProblem, rivals: Losses) -> list[str]:
    """Rivals that these data cannot rule out, the likeliest first."""
    return [
        rival
        for loss, rival in sorted((loss, rival) for rival, loss in rivals.items())
        if loss < problem.need
    ]


def _rivals(problem: ArmProblem, done: ArmFit, mine: list[Key]) -> Losses:
    """What is lost where all that another name can do stands in the place of some values, or the zero of one
    joint's sensor.
    """
    others, cost = [k for k in done.values if k not in mine], problem.solve(list(done.values))[2]
    free = [k for k in problem.candidates if k not in others and owner(k) not in {owner(k) for k in mine}]
    names = dict.fromkeys(owner(k) for k in free if k[0] != ZERO)
    trials = [[k for k in free if owner(k) == name] for name in names] + [[k] for k in free if k[0] == ZERO]
    if not problem.arm.is_planar:  # a frame moves as a whole; values for all joints together fit anything
        trials = [keys if keys[0][1] < 0 else _best_few(problem, others, keys, len(mine)) for keys in trials]
    out: Losses = {}
    for keys in trials:
        told = UNKNOWN if keys[0][0] in NAMELESS else owner(keys[0])
        out[told] = min(problem.solve([*others, *keys])[2] - cost, out.get(told, np.inf))
    return out


def _best_few(problem: ArmProblem, others: list[Key], free: list[Key], most: int) -> list[Key]:
    """Of some values those that do most together, no more than there were before."""
    chosen: list[Key] = []
    while len(chosen) < min(most, len(free)):
        more = [k for k in free if k not in chosen]
        chosen.append(min(more, key=lambda k: problem.solve([*others, *chosen, k])[2]))
    return chosen


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
    """As in the wires; less where the same may be on another joint, or no value is well above its spread."""
    sure = likely(problem.need * len(mine), sum(done.gain[k] for k in mine), losses, EITHER)
    sizes = [abs(done.values[k] - problem.known.get(k, 0.0)) / max(done.std[k], TINY) for k in mine]
    return round(min(sure, 1.0 if max(sizes) > SURE else 0.5), 3)


def _evidence(
    problem: ArmProblem, done: ArmFit, mine: list[Key], rivals: Losses, signature: str
) -> dict[str, Any]:
    gain = sum(done.gain[k] for k in mine)
    strength = float(np.sqrt(gain / (len(problem.signals) * problem.count)))
    return evidence_of(strength, signature, gain={ARM: gain}, rivals=rivals)


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
    heading = theta.cumsum(axis=1) if problem.arm.is_planar else theta
    bent = problem.arm.joints[int(np.argmax(_varies(problem, off, heading)))]
    said = f"the tip is off in a way that no name fits, most with the direction of the link of {bent}"
    said += f" and the angle of {' and '.join(varies)}"
    return Finding(
        effect=UNKNOWN,
        stage="arm",
        joints=[bent],
        regime="posture",
        confidence=UNNAMED,
        equivalents=[],
        parameters={},
        depends_on=["position", *varies],
        statement=f"{said}; {share:.0%} of it is left by lengths and tilt.",
        evidence=evidence_of(rms(off), "The tip is not where the joints put it."),
    )
