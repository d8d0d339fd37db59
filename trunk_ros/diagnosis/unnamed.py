"""A smooth curve in the place of physics that no name fits."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lombscargle

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.align import SLOW
from trunk_ros.diagnosis.explanation import Explanation, Term
from trunk_ros.diagnosis.fit import Fit, fit
from trunk_ros.diagnosis.problem import Problem
from trunk_ros.effects import effect
from trunk_ros.effects.curve import KNOTS, abscissa

UNKNOWN = "unknown"
FRICTION = "unknown_friction"
GAIN = "unknown_gain"
BUMP = 1e-4  # rad of a dead band, for derivatives
TURNS_OF_FRICTION = 6
RIDGE = 1e-3  # of a knot's weight, so that knots without data stay near their neighbours
STRETCH = 12_000  # samples of a spectrum
TURNS = 3  # of curve and named values, each fitted while the other rests


def curve_fit(problem: Problem, bare: Explanation, column: int) -> Fit | None:
    """The explanation with the curve, of the angle, the dead band or the gain, over whatever it is best drawn
    over, that explains most of a column's rest.
    """
    if problem.stage != "wire":
        return None
    bare = fit(problem, bare, [column]).explanation
    over = variables(problem, column)
    own = [] if column in problem.wide else [v for v in over if v not in problem.joints]
    kinds = {UNKNOWN: over, FRICTION: own, GAIN: [v for v in over if own and v != "position"]}
    fits = [_best(problem, bare, column, kind, some) for kind, some in kinds.items() if some]
    return min(fits, key=lambda f: f.cost[column])


def _best(problem: Problem, bare: Explanation, column: int, kind: str, over: list[str]) -> Fit:
    """The curve over the variable that a linear look finds best, fitted."""
    rest = problem.whitened(bare, column)
    costs = {}
    for variable in over:
        design = _design(problem, bare, column, kind, variable, np.zeros(KNOTS))
        costs[variable] = float(np.sum((rest - design @ _solve(design, rest)) ** 2))
    return _alternate(problem, bare, column, kind, min(costs, key=costs.__getitem__))


def _alternate(problem: Problem, bare: Explanation, column: int, kind: str, variable: str) -> Fit:
    """Curve and named values in turn, as long as that helps."""
    low, high = ends(problem, column, variable)
    values = np.zeros(KNOTS)
    done = fit(problem, with_curve(bare, kind, column, variable, low, high, values), [column])
    for _ in range(TURNS_OF_FRICTION if kind == FRICTION else TURNS):
        design = _design(problem, done.explanation, column, kind, variable, values)
        moved = values + _solve(design, problem.whitened(done.explanation, column))
        trial = fit(problem, with_curve(done.explanation, kind, column, variable, low, high, moved), [column])
        if trial.cost[column] > done.cost[column]:
            break
        done, values = trial, moved
    return done


def _design(
    problem: Problem, now: Explanation, column: int, kind: str, variable: str, values: Array
) -> Array:
    """(rows, knots) change of the whitened prediction per curve value."""
    if kind == UNKNOWN:
        return design_of(problem, column, variable)
    low, high = ends(problem, column, variable)

    def predictions(at: Array) -> list[Array]:
        return problem.predictions(with_curve(now, kind, column, variable, low, high, at), column)

    base = predictions(values)
    steps = [predictions(values + BUMP * one) for one in np.eye(KNOTS)]
    changes = [[(p - b) / BUMP for p, b in zip(there, base, strict=True)] for there in steps]
    return np.column_stack([problem.whiten_change(change, column) for change in changes])


def with_curve(
    bare: Explanation, kind: str, column: int, variable: str, low: float, high: float, values: Array
) -> Explanation:
    """The explanation with a curve on a column."""
    out = bare.copy()
    names = knot_names()
    term = out.setdefault(kind, Term(kind, given=frozenset(p.name for p in effect(kind).parameters)))
    term.own[column] = {"low": low, "high": high, **dict(zip(names, values.tolist(), strict=True))}
    term.words[column] = {"on": variable}
    return out


def variables(problem: Problem, column: int) -> list[str]:
    """What a curve may be drawn over: words of the effect ``unknown``."""
    others = [joint for k, joint in enumerate(problem.joints) if k != column]
    load = ["load"] if problem.has_load else []
    hidden = column in problem.wide
    speed = ["speed"] if problem.step < SLOW and not hidden else []
    time = [] if hidden or column in problem.one_way else ["time"]
    return ["position", *speed, *time, *load, *others]


def knot_names() -> list[str]:
    """The curve's values among the parameters of ``unknown``."""
    return [p.name for p in effect(UNKNOWN).parameters if p.name.startswith("value_")]


def ends(problem: Problem, column: int, variable: str) -> tuple[float, float]:
    """Range of a variable over all spans."""
    parts = [abscissa(variable, problem.now(i, column, 0.0), 0) for i in range(len(problem.views))]
    low, high = min(float(p.min()) for p in parts), max(float(p.max()) for p in parts)
    return low, max(high, low + max(1e-6, 1e-6 * abs(low)))


def design_of(problem: Problem, column: int, variable: str) -> Array:
    """(rows, knots) change of the whitened prediction per curve value."""
    low, high = ends(problem, column, variable)
    knots = np.linspace(low, high, len(knot_names()))
    basis = CubicSpline(knots, np.eye(len(knots)), bc_type="natural")
    parts = []
    for i, view in enumerate(problem.views):
        x = abscissa(variable, problem.now(i, column, 0.0), 0)[view.span.rows]
        parts.append(basis(np.clip(x, low, high)))
    return np.column_stack(
        [problem.whiten_change([p[:, k] for p in parts], column) for k in range(len(knots))]
    )


def _solve(design: Array, rest: Array) -> Array:
    """Least squares with second differences held small where data are rare."""
    n = design.shape[1]
    bend = np.diff(np.eye(n), 2, axis=0)
    normal = design.T @ design
    weight = RIDGE * float(np.trace(normal)) / n
    return np.asarray(
        np.linalg.solve(normal + weight * bend.T @ bend + 1e-9 * weight * np.eye(n), design.T @ rest)
    )


def spectrum(stamp: Array, residual: Array, longest: float = 50.0) -> tuple[float, float]:
    """(frequency Hz, share of the power) of the strongest line in a residual (n,) at uneven stamps (n,).

    The effort grows with the square of the length: of a long one the loudest stretch is looked at.
    """
    pieces = range(0, max(len(stamp) - STRETCH, 0) + 1, STRETCH)
    loudest = max(pieces, key=lambda k: float(np.sum(residual[k : k + STRETCH] ** 2)))
    stamp, residual = (values[loudest : loudest + STRETCH] for values in (stamp, residual))
    step = float(np.median(np.diff(stamp)))
    span = float(stamp[-1] - stamp[0])
    frequencies = np.arange(2.0 / span, min(0.45 / step, longest), 0.5 / span)
    if len(frequencies) < 2 or not np.any(residual):
        return 0.0, 0.0
    power = lombscargle(stamp, residual - residual.mean(), 2 * np.pi * frequencies)
    best = int(np.argmax(power))
    return float(frequencies[best]), float(2 * power[best] / np.sum((residual - residual.mean()) ** 2))
