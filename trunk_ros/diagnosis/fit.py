"""Least squares of an explanation's free values, joint by joint or together where values are shared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.explanation import Explanation, Free, bounds, scales
from trunk_ros.diagnosis.problem import Problem

STEP = 0.005  # of a parameter's usual size, for derivatives
EVALUATIONS = 15


@dataclass(frozen=True)
class Fit:
    """A fitted explanation and what is left of the squared unit-noise residual, by column."""

    explanation: Explanation
    cost: dict[int, float]
    """Sum of squares by column."""
    free: list[Free]
    jacobian: Array

    @property
    def total(self) -> float:
        """Sum of squares over the fitted columns."""
        return float(sum(self.cost.values()))


class Residuals:
    """The residual vector of some columns as a function of the free values, and its derivative."""

    def __init__(self, problem: Problem, explanation: Explanation, columns: list[int]):
        self.problem, self.explanation, self.columns = problem, explanation, columns
        self.free = explanation.free(columns)
        self.scale = scales(self.free)
        self._at: tuple[bytes, list[Array]] | None = None

    def parts(self, x: Array) -> list[Array]:
        """Residuals by column."""
        if self._at is None or self._at[0] != x.tobytes():
            there = self.explanation.put(self.free, x)
            self._at = x.tobytes(), [self.problem.whitened(there, c) for c in self.columns]
        return self._at[1]

    def __call__(self, x: Array) -> Array:
        """All residuals, joined."""
        return np.concatenate(self.parts(x))

    def jacobian(self, x: Array) -> Array:
        """(rows, free) by forward differences; a joint's own value touches only its own rows."""
        base = self.parts(x)
        ends = np.cumsum([0, *(len(part) for part in base)])
        out = np.zeros((ends[-1], len(x)))
        _, high = bounds(self.free)
        for k, f in enumerate(self.free):
            step = STEP * self.scale[k] * (1.0 if x[k] + STEP * self.scale[k] <= high[k] else -1.0)
            moved = x.copy()
            moved[k] += step
            there = self.explanation.put(self.free, moved)
            touched = self.explanation[f.effect].columns if f.column is None else [f.column]
            for i, column in enumerate(self.columns):
                if column in touched or f.parameter.name == "payload":
                    out[ends[i] : ends[i + 1], k] = (self.problem.whitened(there, column) - base[i]) / step
        return out


def fit(
    problem: Problem, explanation: Explanation, columns: list[int], evaluations: int = EVALUATIONS
) -> Fit:
    """Fit what is free on ``columns``. Shared values move only where all joints that they act on are
    among the columns.
    """
    residuals = Residuals(problem, explanation, columns)
    x = explanation.get(residuals.free)
    jacobian = np.zeros((0, 0))
    if len(x):
        low, high = bounds(residuals.free)
        x = np.clip(x, low, high)
        inside = np.clip(x, low + 1e-9 * residuals.scale, high - 1e-9 * residuals.scale)
        solution = least_squares(
            residuals,
            inside,
            jac=residuals.jacobian,
            bounds=(low, high),
            x_scale=residuals.scale,
            ftol=1e-5,
            xtol=1e-5,
            gtol=1e-8,
            max_nfev=evaluations,
        )
        x, jacobian = solution.x, solution.jac
    cost = {c: float(part @ part) for c, part in zip(columns, residuals.parts(x), strict=True)}
    return Fit(explanation.put(residuals.free, x), cost, residuals.free, jacobian)
