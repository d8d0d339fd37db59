"""Over what a finding's signature is drawn, and the points and the curve that show it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import STILL
from trunk_ros.diagnosis.report.regimes import JUST
from trunk_ros.diagnosis.report.signals import Signal, joint_angle, load, reversals, signals
from trunk_ros.diagnosis.report.units import multiple
from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effects import registry
from trunk_ros.effects.curve import SPEED_OF
from trunk_ros.effects.now import View
from trunk_ros.effects.wire.unknown_cycle import UnknownCycle
from trunk_ros.effects.wire.unknown_waves import UnknownWaves

POINTS = 1500
CELLS = 60
CELLS_OVER = {"time": 240, "travel": 30}
PERIODS = 4.0  # of what comes back in time

BY_REGIME = {
    "reversal": View("travel", along=True), "low_speed": View("speed", along=True),
    "hold": View("time", window=20.0), "high_speed": View("speed"), "posture": View("position"),
}  # fmt: skip
LABELS = {"time": "time / s", "load": "load moment / N·m", "speed": "speed / rad/s"}


def view_of(finding: Finding, joint: str) -> View:
    """What shows a finding best on one of its joints."""
    kind = registry().get(finding.effect)
    if kind is not None and kind.view is not None:
        return kind.view
    view = View("time") if finding.stage == "arm" else BY_REGIME.get(finding.regime, View("time"))
    held = finding.parameters.get(joint, {})
    words = [held.get(text, {}).get("value") for text in kind.texts] if kind is not None else []
    first = str(
        next(filter(None, words), finding.curve.get("on"))
        or (finding.depends_on[0] if finding.depends_on else "")
    )
    if finding.curve.get("of") in (UnknownCycle.of, UnknownWaves.of):
        return View("time", window=PERIODS * float(np.ptp(finding.curve["joints"][joint]["x"])))
    if view.over == "position" or not finding.named:
        return View(first or view.over, along=finding.regime == "reversal")
    return view


@dataclass(frozen=True)
class Cloud:
    """Points (n,) left by the model without a finding, and the finding's curve (m,), in readable units."""

    x: Array
    y: Array
    curve_x: Array
    curve_y: Array
    x_label: str
    y_label: str
    log: bool


def cloud(result: Answer, view: View, signal: Signal, part: Array) -> Cloud:
    """The signature of one finding on one signal; ``part`` (n,) is what it adds to the prediction.

    The points are the error that is left with everything but this finding in the model.
    """
    x, keep = abscissa(result, view, signal)
    sign, slid = _motion(result, view, signal)
    y = (signal.error_after + part) * sign
    keep &= np.isfinite(y) & np.isfinite(x) & (slid | (view.over == "travel"))
    keep &= _window(view, signal, part)
    if view.over == "travel":
        keep &= _moves(signal)
    log = view.along and view.over in ("travel", "speed")
    if log:
        keep &= x > (max(1e-4 * float(np.nanmax(x)), 1e-9))
    x, y, drawn = x[keep], y[keep], (part * sign)[keep]
    factor, unit = multiple(float(np.quantile(np.abs(y), 0.99)) if len(y) else 1.0, signal.unit)
    units = {s.name: s.unit for s in signals(result) if s.stage == signal.stage}
    scale, x_label = _scaled(view, signal, units.get(view.over.removeprefix(SPEED_OF), signal.unit), x)
    curve = (x, drawn) if view.window else _means(x, drawn, log, CELLS_OVER.get(view.over, CELLS))
    few = np.linspace(0, len(x) - 1, min(len(x), POINTS)).astype(int)
    side = " along the motion" if view.along else ""
    return Cloud(
        scale * x[few],
        factor * y[few],
        scale * curve[0],
        factor * curve[1],
        x_label,
        f"residual{side} / {unit}",
        log,
    )


def abscissa(result: Answer, view: View, signal: Signal) -> tuple[Array, np.ndarray]:
    """(n,) what a view is over in SI units, time where it is not known; (n,) where it can be used."""
    keep = np.ones(len(signal.stamp), dtype=bool)
    angle = joint_angle(result, signal)
    x: Array | None = signal.stamp
    if view.over == "position":
        x = signal.gearbox if signal.stage == "servo" else angle
    elif view.over == "load":
        x = load(result, signal)
    elif view.over == "speed" and signal.velocity is not None and angle is not None:
        ratio = result.model.arm.ratio[result.model.arm.index(signal.name)]
        x = np.asarray(signal.velocity * (1.0 if signal.stage == "servo" else ratio))
    elif view.over == "travel" and angle is not None:
        x = reversals(angle)[1]
    elif view.over != "time":
        x = _of_another(result, signal, view.over)
    x = signal.stamp if x is None else np.asarray(x, dtype=float)
    return (np.abs(x) if view.along and view.over in ("load", "speed") else x), keep


def _of_another(result: Answer, signal: Signal, over: str) -> Array:
    """(n,) another joint's angle or speed, time where it is not known."""
    joint = over.removeprefix(SPEED_OF)
    others = [s for s in signals(result) if (s.stage, s.name) == (signal.stage, joint)]
    if not others:
        return signal.stamp
    if over == joint or others[0].velocity is None:
        angle = joint_angle(result, others[0])
        return signal.stamp if angle is None else angle
    return np.asarray(others[0].velocity * result.model.arm.ratio[result.model.arm.index(joint)])


def _motion(result: Answer, view: View, signal: Signal) -> tuple[Array, np.ndarray]:
    """Sign of the motion (n,), ones where it does not matter, and where the dead band has been crossed."""
    angle = joint_angle(result, signal)
    if not view.along or angle is None:
        return np.ones(len(signal.stamp)), np.ones(len(signal.stamp), dtype=bool)
    direction, travel = reversals(angle)
    return direction, travel > JUST * float(np.ptp(angle))


def _moves(signal: Signal) -> np.ndarray:
    """(n,): where it does not stand, for there the steps of an encoder pass for reversals."""
    if signal.velocity is None:
        return np.ones(len(signal.stamp), dtype=bool)
    speed = np.abs(signal.velocity)
    return np.asarray(speed > STILL * float(np.quantile(speed, 0.99)))


def _window(view: View, signal: Signal, part: Array) -> np.ndarray:
    """(n,): the stretch of time in which the finding does most."""
    length = float(signal.stamp[-1] - signal.stamp[0])
    if not view.window or length <= view.window:
        return np.ones(len(signal.stamp), dtype=bool)
    edges = np.arange(signal.stamp[0], signal.stamp[-1] - view.window, view.window / 4)
    first, last = np.searchsorted(signal.stamp, edges), np.searchsorted(signal.stamp, edges + view.window)
    total, power = (np.concatenate([[0.0], np.cumsum(part**k)]) for k in (1, 2))
    count = np.maximum(last - first, 1)
    spread = (power[last] - power[first]) / count - ((total[last] - total[first]) / count) ** 2
    best = edges[int(np.argmax(spread * (last - first > 0.5 * np.median(count))))]
    return np.asarray((signal.stamp >= best) & (signal.stamp <= best + view.window))


def _means(x: Array, y: Array, log: bool, cells: int) -> tuple[Array, Array]:
    """Mean of ``y`` in cells of ``x``, those with few samples left out."""
    if len(x) < 2 or float(np.ptp(x)) == 0.0:
        return x, y
    edges = np.geomspace(x.min(), x.max(), cells + 1) if log else np.linspace(x.min(), x.max(), cells + 1)
    cell = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, cells - 1)
    count = np.bincount(cell, minlength=cells)
    full = count >= 2
    mean_x, mean_y = (np.bincount(cell, weights=v, minlength=cells)[full] / count[full] for v in (x, y))
    return mean_x, mean_y


def _scaled(view: View, signal: Signal, unit: str, x: Array) -> tuple[float, str]:
    """Factor and label of the abscissa; ``unit`` of the joint that it is an angle of."""
    if view.over.startswith(SPEED_OF):
        return 1.0, f"{view.over} / {unit}/s"
    if view.over in LABELS:
        return 1.0, LABELS[view.over].replace("rad", unit)
    size = 0.01 if view.over == "travel" else float(np.max(np.abs(x), initial=0.0))
    factor, label = multiple(size, unit)
    if view.over == "travel":
        return factor, f"travel since the reversal / {label}"
    if label == "mrad":
        factor, label = math.degrees(1.0), "°"
    what = "gearbox angle" if signal.stage == "servo" else "joint angle asked for by the gearbox"
    return factor, f"{what if view.over == 'position' else view.over} / {label}"
