"""What the arm stage found, in the words of ``diagnosis.json``."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.arm_stage import ArmFit, ArmProblem
from trunk_ros.diagnosis.findings import ARM, statement_of, value_of
from trunk_ros.diagnosis.leftover import accounted
from trunk_ros.diagnosis.result import Finding
from trunk_ros.effects import effect
from trunk_ros.model import Values


def arm_findings(problem: ArmProblem, done: ArmFit) -> tuple[list[Finding], dict[str, Values]]:
    """Findings of the arm stage, and their values for the model."""
    out, values = [], {}
    joints = problem.arm.joints
    for name in dict.fromkeys(name for name, _ in done.values):
        kind, p = effect(name), effect(name).parameters[0]
        mine = {c: v for (n, c), v in done.values.items() if n == name}
        named = [joints[c] for c in mine if c >= 0]
        parameters = {
            (joints[c] if c >= 0 else ARM): {p.name: value_of(v, done.std[name, c], p.unit)}
            for c, v in sorted(mine.items())
        }
        column: Array = np.zeros(len(joints))
        for c, v in mine.items():
            column[c] = v
        values[name] = {p.name: mine.get(-1, column)}
        gain = sum(done.gain[name, c] for c in mine)
        out.append(
            Finding(
                name,
                "arm",
                sorted(named),
                kind.regime,
                0.97,
                [],
                parameters,
                [],
                statement_of(kind, ", ".join(sorted(named)) or "the arm", parameters),
                {
                    "strength": float(np.sqrt(gain / (3 * problem.count))),
                    "gain": {ARM: gain},
                    "rivals": {},
                    "form": "",
                    "signature": kind.signature,
                },
            )
        )
    return out, values


def _link(problem: ArmProblem) -> int:
    """The joint (column) with whose link's direction the tip's error varies most."""
    off = np.concatenate(problem.residual({})) / problem.noise
    headings = np.concatenate([d.theta for d in problem.data]).cumsum(axis=1)
    told = [sum(accounted(heading, signal) * signal.var() for signal in off.T) for heading in headings.T]
    return int(np.argmax(told))


def unknown_arm_finding(problem: ArmProblem, share: float) -> Finding:
    """The tip is off in a way that neither lengths nor tilt explain: where, and on which joints' angles it
    depends.
    """
    residual = np.concatenate([r[:, 0] for r in problem.residual({})])
    theta = np.concatenate([d.theta for d in problem.data])
    told = {joint: accounted(theta[:, c], residual) for c, joint in enumerate(problem.arm.joints)}
    varies = sorted(told, key=lambda joint: -told[joint])[:2]
    bent = problem.arm.joints[_link(problem)]
    said = f"the tip is off in a way that no name fits, most with the direction of the link of {bent}"
    said += f" and the angle of {' and '.join(varies)}"
    return Finding(
        effect="unknown",
        stage="arm",
        joints=[bent],
        regime="posture",
        confidence=0.9,
        equivalents=[],
        parameters={},
        depends_on=["position", *varies],
        statement=f"{said}; {share:.0%} of it is left by lengths and tilt.",
        evidence={
            "strength": float(np.sqrt(np.mean((residual / problem.noise[0]) ** 2))),
            "gain": {},
            "rivals": {},
            "form": "",
            "signature": "The tip is not where the joints put it.",
        },
    )
