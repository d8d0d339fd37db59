"""The nominal servo of an arm of whose servos nothing is said: found in the recording first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.arm_model import SAMPLED
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.against import with_room
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.align import servo_span
from trunk_ros.diagnosis.data.excerpt import excerpt
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.levels import CLEARLY, OUTLIERS, SEVERAL
from trunk_ros.diagnosis.search.score import SIGNIFICANT
from trunk_ros.diagnosis.servo import ServoStage
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

STIFFEST = 2000.0  # 1/s: what answers faster is where it was asked to be, for all that can be seen
SWINGS = 1.0  # kp tau_v of a loop with half of critical damping: no servo is tuned to swing longer
STARTS = (5.0, 20.0, 80.0, 320.0), (0.1, 0.5), (0.0, 0.02, 0.08)
"""kp [1/s], kp tau_v, delay [s]."""
TOPS = (1.0, 3.0)  # v_max over the highest speed seen: one that is reached, and one that is left open
STEPS = np.array([0.01, 0.01, 0.01, 1e-3])  # of logarithms, and s


def with_its_servo(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model with the first-order loop that each joint's servo is: its gain, velocity loop, top speed and
    delay. What is found beyond is what such a loop cannot do.

    Setpoints may be samples that were taken beside the shaft's angle, of what moves on between them: so they
    are where the shaft is clearly nearer to what follows from that.
    """
    held, left = _identified(model, recordings)
    sampled, less = _identified(replace(model, setpoints=SAMPLED), recordings)
    return sampled if CLEARLY * less < left else held


def _identified(model: Model, recordings: Sequence[Recording]) -> tuple[Model, float]:
    """The model with its servos, and what these leave, rms over the joints [rad]."""
    unlimited = with_room(model, recordings)
    context = first_look(ServoStage([excerpt(servo_span(r, unlimited)) for r in recordings], unlimited))
    arm, squares = model.arm, 0.0
    numbers: dict[str, Any] = {name: np.full(len(arm.joints), getattr(arm, name)) for name in SERVO_OF_EACH}
    for column in context.columns:
        fastest = _fastest(context, column)
        if fastest == 0.0:
            continue
        found, cost = _loop(context, column, fastest)
        for name, value in zip(SERVO_OF_EACH, found, strict=True):
            numbers[name][arm.index(context.joints[column])] = value
        squares += cost * context.noise[column].std ** 2 / context.count(column)
    return replace(model, arm=replace(arm, **numbers, servo_stated=True)), float(np.sqrt(squares))


def _fastest(context: Context, column: int) -> float:
    """The highest speed of a joint [rad/s], but for a few samples of those in which it moves; 0 where it was
    not asked to, or did not.
    """
    spans = [view.span for view in context.views if np.ptp(view.span.source[:, column]) > 0.0]
    speeds = [speed[speed > 0.0] for speed in (np.abs(span.velocity[:, column]) for span in spans)]
    return max((float(np.quantile(s, 1.0 - OUTLIERS)) for s in speeds if len(s)), default=0.0)


def _loop(context: Context, column: int, fastest: float) -> tuple[Array, float]:
    """(4,) numbers of the servo of a joint that went as ``fastest`` rad/s, as in SERVO_OF_EACH, and what is
    left of its squared residual: the best of the fits from the best starts.
    """
    stage = context.stage

    def residual(x: Array) -> Array:
        own = dict(zip(SERVO_OF_EACH, _numbers(x).tolist(), strict=True))
        here = replace(context, stage=stage.of(replace(stage.arm, **own)))
        return here.whitened(context.known, column)

    def slopes(x: Array) -> Array:
        base = residual(x)
        steps = np.where(x + STEPS < high, STEPS, -STEPS)
        return np.column_stack([(residual(x + np.eye(4)[k] * h) - base) / h for k, h in enumerate(steps)])

    low = np.array([*np.log([0.5, 1e-3, 0.3 * fastest]), 0.0])
    high = np.array([*np.log([STIFFEST, SWINGS, 20.0 * fastest]), 0.5])
    fits = []
    for top in TOPS:  # a limit that is reached, and one that is not, hide each other
        starts = [
            np.array([*np.log([kp, swings, fastest * top]), late]) for kp, swings, late in product(*STARTS)
        ]
        starts.sort(key=lambda x: float(np.sum(residual(x) ** 2)))
        for x, method in product(starts[:SEVERAL], ("dogbox", "trf")):  # one goes on where the other stands
            fits.append(least_squares(residual, x, slopes, (low, high), method, x_scale="jac", max_nfev=60))
    best = min(fits, key=lambda fit: float(fit.cost))
    cost = 2.0 * float(best.cost)
    free = np.array([*best.x[:2], np.log(TOPS[-1] * fastest), best.x[3]])
    reached = float(np.sum(residual(free) ** 2)) - cost > SIGNIFICANT  # else the top speed is not known
    return _numbers(best.x if reached else free), cost


def _numbers(x: Array) -> Array:
    """kp, tau_v, v_max and delay of what is fitted."""
    kp, swings, fastest = np.exp(x[:3])
    return np.array([kp, swings / kp, fastest, x[3]])
