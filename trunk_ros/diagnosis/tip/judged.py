"""The arm stage of a diagnosis: which fit to the tip holds, and what it says."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import APART
from trunk_ros.data.noise import FLOOR, rms
from trunk_ros.diagnosis.context import LEAST
from trunk_ros.diagnosis.evidence.residual_dependence import goes_on
from trunk_ros.diagnosis.tip.data import UNITS, tip_data
from trunk_ros.diagnosis.tip.findings import arm_findings, unknown_arm_finding
from trunk_ros.diagnosis.tip.lasting import lasting_on
from trunk_ros.diagnosis.tip.stage import ArmFit, ArmProblem
from trunk_ros.diagnosis.tip.values import model_effects
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effect_values import Values
from trunk_ros.levels import LITTLE
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.signal.resample import SLOW

Told = tuple[dict[str, Any], list[Finding], dict[str, Values]]


def fitted_tip(
    recordings: list[Recording], model: Model, late: float, lasting: dict[str, tuple[float, float]]
) -> tuple[ArmProblem, ArmFit] | None:
    """Joint angles and tip at the same moments, and the fit to them: a joint sensor that is ``late`` s is not
    blamed on the arm. None where too little of the tip was recorded.

    ``model``: with what was found of the wires; ``lasting``: by joint, noise [rad] that lasts from sample
    to sample, and how long [s] it stays the same.
    """
    noise = lasting_on(model.arm.joints, lasting)
    fitted = []
    for delay in {0.0, late}:  # a simulated tip may be as late as the joints
        data = [d for d in (tip_data(r, model, delay) for r in recordings) if d is not None]
        if sum(len(d.stamp) for d in data) >= LEAST:
            problem = ArmProblem(data, noise, model.effects)
            fitted.append((problem, problem.run()))
    return min(fitted, key=_left, default=None)


def judged_tip(problem: ArmProblem, done: ArmFit) -> Told:
    """What the stage comes to, its findings, and all that the arm then has for the model."""
    before = np.concatenate(problem.residual(problem.known))
    after = problem.held_out(list(done.values))
    tip = {
        signal: {
            "unit": UNITS[signal],
            "rmse_before": rms(before[:, k]),
            "rmse_after": rms(after[:, k]),
            "noise_floor": float(problem.noise[k]),
        }
        for k, signal in enumerate(problem.signals)
    }
    misfit, rest = (float(np.mean((off / problem.noise) ** 2)) - 1.0 for off in (before, after))
    joints = len(problem.arm.joints)
    stage = {"compared": True, "tip": tip, "strays": problem.strays}
    if rest > max(1.0, LITTLE * misfit) and _goes_on(problem, after):
        said = unknown_arm_finding(problem, rest / max(misfit, rest))
        return stage, [said], model_effects(problem.known, joints)
    return stage, arm_findings(problem, done), model_effects(problem.known | done.values, joints)


def _goes_on(problem: ArmProblem, after: Array) -> bool:
    """Whether what is left (n, signals) lasts from sample to sample; of rare poses that is not known."""
    steps = np.concatenate([np.diff(data.stamp) for data in problem.data])
    if not len(steps) or float(np.median(steps)) >= SLOW:
        return True
    off = after / problem.noise
    return any(goes_on(one[APART:] * one[:-APART], 0.0, 0.0) for one in off.T)


def _left(fitted: tuple[ArmProblem, ArmFit]) -> float:
    """How much a fit leaves, whatever the signals' units."""
    problem, done = fitted
    rest = np.concatenate(problem.residual(problem.known | done.values))
    return float(np.log(np.mean(rest**2, axis=0) + FLOOR**2).sum())
