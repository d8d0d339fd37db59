"""The first-order loop that a joint's servo is, fitted to a recording."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from scipy.optimize import least_squares

from trunk_ros.arm.arm import SERVO_OF_EACH
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import HALF, OUTLIERS
from trunk_ros.diagnosis.search.candidates import Candidate, extended, usable
from trunk_ros.diagnosis.search.starts import Starts
from trunk_ros.guards import ROUNDED, TINY
from trunk_ros.parameter import leading

RECORDED = "effort"  # what effects need that go by a recorded torque
STIFFEST = 2000.0  # 1/s: what answers faster is where it was asked to be, for all that can be seen
SWINGS = 1.0 / (2.0 * HALF) ** 2  # kp tau_v of a loop with half of critical damping: no servo swings longer
STEPS = np.array([0.01, 0.01, 0.01, 1e-3, 0.01])  # of logarithms, s, and a share


def fastest_of(context: Context, column: int) -> float:
    """The highest speed of a joint [rad/s], but for a few samples of those in which it moves; 0 where it was
    not asked to, or did not.
    """
    spans = [view.span for view in context.views if np.ptp(view.span.source[:, column]) > 0.0]
    speeds = [speed[speed > 0.0] for speed in (np.abs(span.velocity[:, column]) for span in spans)]
    return max((float(np.quantile(s, 1.0 - OUTLIERS)) for s in speeds if len(s)), default=0.0)


@dataclass(frozen=True)
class Loop:
    """What is fitted of a joint's servo: logarithms of kp, kp tau_v and the top speed, the delay s, and the
    share of the setpoint's speed where it has five numbers.
    """

    context: Context
    column: int
    low: Array
    high: Array
    pulled: tuple[Hypothesis, ...] = ()
    """With the load pulling at the servo, and with what of its torque the drive may feed forward, each by as
    much as leaves least; none: nothing does.
    """

    @staticmethod
    def of(context: Context, column: int) -> Loop:
        """Of a joint that went at some speed."""
        fastest = fastest_of(context, column)
        low = np.array([*np.log([0.5, 1e-3, 0.3 * fastest]), 0.0, 0.0])
        high = np.array([*np.log([STIFFEST, SWINGS, 20.0 * fastest]), 0.5, 2.0])
        return Loop(context, column, low, high)

    @staticmethod
    def pulled_at(context: Context, column: int) -> list[Loop]:
        """Of the same joint with what it bears pulling at its servo, and also with what the drive may feed
        forward of that; none where nothing is known of it.
        """
        loads = [kind for kind in usable(context) if kind.bears(kind.apart) and kind.apart]
        if not loads or not context.stage.bears(column):
            return []
        kind, known, loop = loads[0], context.known, Loop.of(context, column)
        lead = leading(kind.own_parameters(kind.apart))
        start = {lead.name: lead.typical * lead.under(float(context.stage.loads[column]))}
        begin, fed = Starts(context, known, [column]), [k for k in usable(context) if RECORDED in k.needs]
        more = [Candidate(k.id, k.forms[0], column, s) for k in fed for s in begin.on(k, k.forms[0], column)]
        pulls = [extended(context, known, c) for c in (Candidate(kind.id, kind.apart, column, start), *more)]
        loops = [replace(loop, pulled=tuple(pulls[:1])), replace(loop, pulled=tuple(pulls))]
        return loops if more else loops[:1]

    def at(self, numbers: Array) -> Array:
        """(5,) what is fitted, within its bounds, where a servo has the ``numbers`` (5,)."""
        kp, tau_v, top, late, share = numbers
        logarithms = np.log(np.maximum([kp, kp * tau_v, top], TINY))
        return np.asarray(np.clip([*logarithms, late, share], self.low, self.high))

    def left(self, numbers: Array) -> float:
        """Squared whitened residual."""
        return float(np.sum(self.residual(numbers) ** 2))

    def residual(self, numbers: Array) -> Array:
        """(n,) whitened: what a servo with ``numbers`` (5,) leaves, pulled by as much as explains most."""
        own = dict(zip(SERVO_OF_EACH, numbers.tolist(), strict=True))
        here = replace(self.context, stage=self.context.stage.of(replace(self.context.arm, **own)))
        rest = here.whitened(self.context.known, self.column)
        if not self.pulled:
            return rest
        moved = np.column_stack([here.whitened(pulled, self.column) - rest for pulled in self.pulled])
        return np.asarray(rest - moved @ np.linalg.lstsq(moved, rest, rcond=ROUNDED)[0])

    def fitted(
        self, start: Array, method: Literal["dogbox", "trf"] = "trf", tau_v: float | None = None
    ) -> Any:
        """From a start, (4,) or (5,); with a velocity loop of that ``tau_v`` where it is given."""
        usual, low, high = STEPS[: len(start)], self.low[: len(start)], self.high[: len(start)]

        def residual(x: Array) -> Array:
            return self.residual(numbers_of(x, tau_v))

        def slopes(x: Array) -> Array:
            base = residual(x)
            steps = np.where(x + usual < high, usual, -usual)
            return np.column_stack([(residual(x + h) - base) / h.sum() for h in np.diag(steps)])

        return least_squares(residual, start, slopes, (low, high), method, x_scale="jac", max_nfev=60)


def numbers_of(x: Array, tau_v: float | None = None) -> Array:
    """(5,) as in SERVO_OF_EACH of what is fitted, without the share of the speed (4,) or with it (5,); with
    that ``tau_v`` where it is given.
    """
    kp, swings, fastest = np.exp(x[:3])
    share = float(x[4]) if len(x) > 4 else 0.0
    return np.array([kp, swings / kp if tau_v is None else tau_v, fastest, x[3], share])
