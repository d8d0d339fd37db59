"""The first-order loop that a joint's servo is, fitted to a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal

import numpy as np
from scipy.optimize import least_squares

from trunk_ros.arm.arm import SERVO_OF_EACH, STEP
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import Candidate, extended, usable
from trunk_ros.diagnosis.search.fit import GAINED
from trunk_ros.diagnosis.search.score import SIGNIFICANT
from trunk_ros.diagnosis.search.starts import Starts
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.guards import ROUNDED, TINY
from trunk_ros.levels import HALF, LITTLE, OUTLIERS, THREEFOLD
from trunk_ros.parameter import leading

RECORDED = "effort"  # what effects need that go by a recorded torque
STIFFEST = 2000.0  # 1/s: what answers faster is where it was asked to be, for all that can be seen
SWINGS = 1.0 / (2.0 * HALF) ** 2  # kp tau_v of a loop with half of critical damping: no servo swings longer
HARDLY_MORE = 2.0  # times the squares of noise: as much again may be what no formula of a loop says
TOP_SPEED = np.array(SERVO_OF_EACH) == "v_max"
STARTS = (5.0, 20.0, 80.0, 320.0), (0.1, 0.5), (0.0, 0.02, 0.08)
"""kp [1/s], kp tau_v, delay [s]."""
TOPS = (1.0, THREEFOLD)  # v_max over the highest speed seen: one that is reached, and one that is left open
FED = (0.3, 1.0)  # shares of the setpoint's speed that are tried first
VALLEYS = STEP * np.array([-1.0, -0.5, 0.5, 1.0])  # s
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
    clipped: Hypothesis | None = None
    """What is known, and limits of the drive."""
    beside: Array | None = None
    """(n,) whitened: a change by as much as leaves least, such as another zero."""

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
        return self.residuals([numbers])[0]

    def residuals(self, some: Sequence[Array], further: Sequence[Hypothesis] = ()) -> list[Array]:
        """The same of several, which are stepped side by side; each with what is known and ``further`` where
        that is given.
        """
        context, stage = self.context, self.context.stage
        assert isinstance(stage, ServoStage)
        known, out = further or [self.clipped or context.known] * len(some), list[Array]()
        width = 1 + len(self.pulled)
        most = max(context.together // width, 1)
        for k in range(0, len(some), most):
            numbers = np.repeat(np.column_stack(some[k : k + most]), width, axis=1)
            here = replace(context, stage=stage.trying(numbers))
            each = [(h, self.column) for one in known[k : k + most] for h in (one, *self.pulled)]
            seen = here.whitened_each(each)
            out += [self._pulled_back(*seen[j : j + width]) for j in range(0, len(seen), width)]
        return out

    def _pulled_back(self, rest: Array, *pulled: Array) -> Array:
        changes = [*(one - rest for one in pulled), *([] if self.beside is None else [self.beside])]
        if not changes:
            return rest
        moved = np.column_stack(changes)
        return np.asarray(rest - moved @ np.linalg.lstsq(moved, rest, rcond=ROUNDED)[0])

    def nearest(self, starts: Iterable[Array], many: int) -> list[Array]:
        """Those of starts, (4,) or (5,), that leave least."""
        some = list(starts)
        left = [float(rest @ rest) for rest in self.residuals([numbers_of(x) for x in some])]
        return [some[k] for k in np.argsort(left, kind="stable")[:many]]

    def fitted(
        self,
        start: Array,
        method: Literal["dogbox", "trf"] = "trf",
        tau_v: float | None = None,
        rough: bool = False,
    ) -> Any:
        """From a start, (4,) or (5,); with a velocity loop of that ``tau_v`` where it is given. ``rough``: as
        far as the search fits, of one among many.
        """
        n = len(start)
        bounds = np.array([self.low[:n], self.high[:n]])

        def residuals(some: Sequence[Array]) -> list[Array]:
            return self.residuals([numbers_of(x, tau_v) for x in some])

        return solved(residuals, start, STEPS[:n], bounds, method, rough)


def solved(
    residuals: Callable[[Sequence[Array]], list[Array]],
    start: Array,
    usual: Array,
    bounds: Array,
    method: Literal["dogbox", "trf"] = "trf",
    rough: bool = False,
) -> Any:
    """Least squares from what is nearest to a start (k,) within ``bounds`` (2, k), with slopes from ``usual``
    steps (k,), all looked at side by side. The start may be that of another drive, with other bounds.
    """
    enough, seen = 1e-4 * GAINED if rough else 1e-8, dict[bytes, Array]()

    def residual(x: Array) -> Array:
        if x.tobytes() not in seen:
            seen.clear()
            (seen[x.tobytes()],) = residuals([x])
        return seen[x.tobytes()]

    def slopes(x: Array) -> Array:
        base, steps = residual(x), np.diag(np.where(x + usual < bounds[1], usual, -usual))
        beside = residuals([x + h for h in steps])
        return np.column_stack([(there - base) / h.sum() for there, h in zip(beside, steps, strict=True)])

    begun, ends = np.clip(start, *bounds), tuple(bounds)
    return least_squares(residual, begun, slopes, ends, method, enough, enough, x_scale="jac", max_nfev=60)


def usual_loops(top: float) -> list[Array]:
    """(4,) each, what is fitted of usual loops with a top speed [rad/s]."""
    return [np.array([*np.log([kp, swings, top]), late]) for kp, swings, late in product(*STARTS)]


def numbers_of(x: Array, tau_v: float | None = None) -> Array:
    """(5,) as in SERVO_OF_EACH of what is fitted, without the share of the speed (4,) or with it (5,); with
    that ``tau_v`` where it is given.
    """
    kp, swings, fastest = np.exp(x[:3])
    share = float(x[4]) if len(x) > 4 else 0.0
    return np.array([kp, swings / kp if tau_v is None else tau_v, fastest, x[3], share])


def is_explained(loop: Loop, cost: float) -> bool:
    """Whether what is left is hardly more than noise."""
    return cost <= HARDLY_MORE * loop.context.count(loop.column)


def with_top(loop: Loop, best: Array, other: Array) -> Array:
    """(5,) the best numbers, with the top speed of others where that leaves no more for sure."""
    there = np.where(TOP_SPEED, other, best)
    return there if loop.left(there) - loop.left(best) <= SIGNIFICANT else best


def cost_of(fit: Any) -> float:
    return float(fit.cost)


def in_its_valley(nearest: Any, fitted: Callable[[Array], Any]) -> Any:
    """The best fit that is near one by the delay: a loop that is stepped is best at some delays."""
    at = np.inf
    while nearest.cost < (1.0 - LITTLE) * at:
        at = nearest.cost
        beside = [fitted(_later(nearest.x, by)) for by in VALLEYS]
        nearest = min([nearest, *beside], key=cost_of)
    return nearest


def _later(x: Array, by: float) -> Array:
    """What is fitted of a loop that is ``by`` s later, and as much quicker."""
    lag, there = np.exp(-x[0]) - by, x.copy()
    there[0], there[3] = -np.log(lag) if lag > 0.0 else x[0], x[3] + by
    return there
