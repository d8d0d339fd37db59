"""Least squares of a hypothesis's free values, joint by joint or together where values are shared."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, bounds
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.residuals import Residuals, worst
from trunk_ros.effects import effect
from trunk_ros.levels import TURNS

ROUNDS = 12
SETTLED = 2  # rounds after which gains only get smaller
TRIES = 6  # dampings a round
DAMPING = 1e-3
GAINED = 0.05  # squared unit-noise residuals: a gain that ends the fit


@dataclass(frozen=True)
class Fit:
    """A fitted hypothesis, what it was fitted in, and what is left of the squared unit-noise residual."""

    hypothesis: Hypothesis
    cost: dict[int, float]
    """Sum of squares by column."""
    context: Context
    priced: list[float] = field(default_factory=list, init=False, repr=False, compare=False)
    """What it is worth, once somebody asked."""

    @property
    def total(self) -> float:
        """Sum of squares over the fitted columns."""
        return float(sum(self.cost.values()))

    def working(self, work: Work) -> Fit:
        """The same, with what is simulated for it from now on counted elsewhere."""
        return replace(self, context=replace(self.context, work=work))

    def rest(self, column: int) -> float:
        """Squared unit-noise residual of a column above the noise."""
        return max(self.cost.get(column, 0.0) - self.context.count(column), 0.0)

    def beyond_noise(self, column: int) -> float:
        """The same above what the noise may be: it is known to a share of its power."""
        return max(self.rest(column) - self.context.rest(column) * self.context.count(column), 0.0)


def fit(
    context: Context, hypothesis: Hypothesis, columns: list[int], goal: float = np.inf, spared: int = 0
) -> Fit:
    """Fit what is free on ``columns``; given up where the squared residuals will not come down to ``goal``,
    even without what is left of the worst columns, so many of which may be ``spared``.

    Shared values move only where all joints that they act on are among the columns.
    """
    residuals = Residuals(context, hypothesis, columns)
    x = hypothesis.free_values(residuals.free)
    if len(x):
        x = minimise(residuals, np.clip(x, *bounds(residuals.free)), ROUNDS, goal, spared)
    cost = {c: float(part @ part) for c, part in zip(columns, residuals.parts(x), strict=True)}
    return Fit(hypothesis.put(residuals.free, x), cost, context)


def refit(context: Context, hypothesis: Hypothesis, goal: float = np.inf, spared: int = 0) -> Fit:
    """Fit joint by joint, or all at once where they share values; with an effect of load, in its own
    postures. Given up where the squared residuals of all will not come down to ``goal``, even without what is
    left of the worst joints, so many of which may be ``spared`` since something else will explain it.
    """
    done = _refit(context, hypothesis, goal, spared)
    if any(effect(n).everywhere and effect(n).bears(term.form) for n, term in hypothesis.items()):
        seen = context.seen_with(done.hypothesis)
        done = done if seen is context else _refit(seen, done.hypothesis, goal, spared)
    for _ in range(TURNS if hypothesis.shakes else 0):
        seen = done.context.seen_with(done.hypothesis)
        if seen is done.context:
            break
        before, done = done, _refit(seen, done.hypothesis, goal, spared)
        if not spared and done.total - goal > abs(before.total - done.total):  # what is to come is less
            break
    return done


def _refit(context: Context, hypothesis: Hypothesis, goal: float, spared: int) -> Fit:
    cost: dict[int, float] = {}
    for group in groups(context, hypothesis):
        others = spared if len(group) > 1 else 0
        done = fit(context, hypothesis, group, _goal_of(context, group, cost, goal, spared), others)
        hypothesis = done.hypothesis
        cost |= done.cost
    return Fit(hypothesis, cost, context)


def _goal_of(context: Context, group: list[int], cost: dict[int, float], goal: float, spared: int) -> float:
    """What the squared residuals of a group have to come to, where those fitted before it have a ``cost`` and
    all others come down to the noise.
    """
    if np.isinf(goal):
        return goal
    left = goal - sum(context.least_noise(c) for c in context.columns if c not in (*cost, *group))
    left -= sum(cost.values())
    among = left + worst(context, cost, spared - 1)
    if len(group) == 1 and spared and among > context.least_noise(group[0]):
        return np.inf  # it may be one of those itself
    return left + worst(context, cost, spared)


def groups(context: Context, hypothesis: Hypothesis) -> list[list[int]]:
    """Columns that have to be fitted together: those that share values, and each of the others alone."""
    columns = context.columns
    shared = {c for term in hypothesis.values() if set(term.shared) - term.given for c in term.columns}
    together = sorted(shared & set(columns))
    return ([together] if together else []) + [[c] for c in columns if c not in shared]


def refit_column(now: Fit, hypothesis: Hypothesis, column: int, goal: float = np.inf) -> Fit:
    """Fit one joint's own values, the rest as it is; given up where its squared residuals will not come down
    to ``goal``.
    """
    trial = fit(now.context, hypothesis, [column], goal)
    return Fit(trial.hypothesis, now.cost | trial.cost, now.context)


def costed_on(now: Fit, hypothesis: Hypothesis, column: int) -> Fit:
    """A hypothesis that differs on one joint, with the values that it has."""
    rest = now.context.whitened(hypothesis, column)
    return Fit(hypothesis, now.cost | {column: float(rest @ rest)}, now.context)


def costed(context: Context, hypothesis: Hypothesis) -> Fit:
    """A hypothesis with the values that it has."""
    cost, columns = dict[int, float](), context.columns
    for first in range(0, len(columns), most := context.together):
        some = columns[first : first + most]
        parts = context.whitened_each([(hypothesis, c) for c in some])
        cost |= {c: float(part @ part) for c, part in zip(some, parts, strict=True)}
    return Fit(hypothesis, cost, context)


def change(context: Context, one: Hypothesis, other: Hypothesis, column: int) -> Array:
    """(rows,) what two hypotheses predict differently on a column, whitened."""
    pairs = zip(context.predictions(one, column), context.predictions(other, column), strict=True)
    return context.whiten_change([a - b for a, b in pairs], column)


def minimise(residuals: Residuals, x: Array, rounds: int, goal: float = np.inf, spared: int = 0) -> Array:
    """Levenberg-Marquardt within bounds. Values that are good enough stay as they are, so that what is known
    of them stays true. It ends where a round gained too little, or as much as its linear look had promised:
    then the next would.

    A value that would move no residual over its usual size stays about where it is: by its own slope, which
    is rounding, it would leap from bound to bound, and no step would pay. Few values against many samples:
    the normal equations cost a tenth of the decompositions that ``scipy.optimize.least_squares`` makes of the
    whole derivative.
    """
    low, high = bounds(residuals.free)
    rest = residuals(x)
    cost, damping = float(rest @ rest), DAMPING
    first, start, held = cost, x, np.diag(residuals.scale**-2.0)
    for done in range(1, rounds + 1):
        slope, normal = residuals.normal_about(x)
        normal = normal + held
        before, looked = cost, x
        for _ in range(TRIES):
            trial = np.clip(x - residuals.turned(step(normal, slope, damping, x, low, high)), low, high)
            there = residuals(trial)
            if float(there @ there) < cost:
                x, rest, cost, damping = trial, there, float(there @ there), damping / 5.0
                break
            damping = max(damping, 1e-6) * 6.0
        enough = max(GAINED, GAINED * 1e-4 * cost)
        if before - cost < enough:
            break
        if done > SETTLED and (rounds - done) * (before - cost) < residuals.but_for(x, spared) - goal:
            break  # it is hopeless
        whole = residuals.turned(step(normal, slope, 0.0, looked, low, high))
        most = residuals.about(looked - np.clip(looked - whole, low, high))
        if _unforeseen(normal, slope, residuals.about(looked - x), most, before - cost) < enough:
            break
    return x if first - cost >= enough else start


def _unforeseen(normal: Array, slope: Array, moved: Array, most: Array, gained: float) -> float:
    """How far what a round ``gained`` is from what its linear look promised for the values that it ``moved``,
    and that from what it promised at ``most``.
    """
    here, there = (float(2.0 * slope @ d - d @ normal @ d) for d in (moved, most))
    return abs(gained - here) + max(there - here, 0.0)


def step(normal: Array, slope: Array, damping: float, x: Array, low: Array, high: Array) -> Array:
    """A damped step; values at a bound that it would cross stay."""
    size = np.sqrt(np.maximum(np.diag(normal), 1e-30))
    moving = ~(((x <= low) & (slope > 0)) | ((x >= high) & (slope < 0)))
    out = np.zeros_like(x)
    scaled = normal[np.ix_(moving, moving)] / np.outer(size[moving], size[moving])
    scaled = scaled + (damping + 1e-9) * np.eye(len(scaled))
    out[moving] = np.linalg.solve(scaled, slope[moving] / size[moving]) / size[moving]
    return out
