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
from trunk_ros.effects.curve import abscissa

UNKNOWN = "unknown"
RIDGE = 1e-3  # of a knot's weight, so that knots without data stay near their neighbours
TURNS = 3  # of curve and named values, each fitted while the other rests


def curve_fit(problem: Problem, bare: Explanation, column: int) -> Fit | None:
    """The explanation with the curve, over whatever it is best drawn over, that explains most of a
    column's rest.
    """
    if problem.stage != "wire":
        return None
    bare = fit(problem, bare, [column]).explanation
    rest = problem.whitened(bare, column)
    best: tuple[float, str] | None = None
    for variable in variables(problem, column):
        design = design_of(problem, column, variable)
        values = _solve(design, rest)
        cost = float(np.sum((rest - design @ values) ** 2))
        if best is None or cost < best[0]:
            best = cost, variable
    return None if best is None else _alternate(problem, bare, column, best[1])


def _alternate(problem: Problem, bare: Explanation, column: int, variable: str) -> Fit:
    design = design_of(problem, column, variable)
    low, high = ends(problem, column, variable)
    values = np.zeros(design.shape[1])
    out = bare.copy()
    for _ in range(TURNS):
        rest = problem.whitened(out, column)
        values = values + _solve(design, rest)
        out = with_curve(bare, column, variable, low, high, values)
        done = fit(problem, out, [column])
        out = bare = done.explanation
    return done


def with_curve(
    bare: Explanation, column: int, variable: str, low: float, high: float, values: Array
) -> Explanation:
    """The explanation with a curve on a column."""
    out = bare.copy()
    names = knot_names()
    term = out.setdefault(UNKNOWN, Term(UNKNOWN, given=frozenset(p.name for p in effect(UNKNOWN).parameters)))
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
    return low, high if high > low else low + 1e-6


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
    """(frequency Hz, share of the power) of the strongest line in a residual (n,) at uneven stamps (n,)."""
    step = float(np.median(np.diff(stamp)))
    span = float(stamp[-1] - stamp[0])
    frequencies = np.arange(2.0 / span, min(0.45 / step, longest), 0.5 / span)
    if len(frequencies) < 2 or not np.any(residual):
        return 0.0, 0.0
    power = lombscargle(stamp, residual - residual.mean(), 2 * np.pi * frequencies)
    best = int(np.argmax(power))
    return float(frequencies[best]), float(2 * power[best] / np.sum((residual - residual.mean()) ** 2))
