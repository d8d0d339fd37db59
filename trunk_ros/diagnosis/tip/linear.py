"""Least squares of the tip, linear about one geometry: any few of the values at little cost."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.guards import BLIND, TINY


class Linear:
    """Residuals that are ``rest`` (n, signals) at the origin and fall by ``slopes`` (n, signals, values) per
    step of each value.
    """

    def __init__(self, rest: Array, slopes: Array, step: Array):
        """``step`` (values,): a usual size of each, in which values of different units are weighed alike."""
        self.rest, self.slopes, self.step = rest, slopes * step, step

    def normal(self, noise: Array, keep: np.ndarray) -> Normal:
        """Normal equations of the rows ``keep`` (n,), the signals having ``noise`` (signals,)."""
        white = (self.slopes[keep] / noise[:, None]).reshape(-1, len(self.step))
        rest = (self.rest[keep] / noise).ravel()
        return Normal(white.T @ white, white.T @ rest, float(rest @ rest), self.step)


class Normal:
    """``curvature`` (values, values), ``pull`` (values,) and squares left at the origin, in unit noise."""

    def __init__(self, curvature: Array, pull: Array, squares: float, step: Array):
        self.curvature, self.pull, self.squares, self.step = curvature, pull, squares, step

    def solve(self, chosen: list[int]) -> tuple[Array, Array, float]:
        """Values (chosen,), their covariance, and the squares left. What the data do not see stays at 0."""
        own, pull = self.curvature[np.ix_(chosen, chosen)], self.pull[chosen]
        inverse = np.linalg.pinv(own, rcond=BLIND, hermitian=True) if chosen else own
        found, step = inverse @ pull, self.step[chosen]
        return found * step, np.outer(step, step) * inverse, self.squares - float(pull @ found)

    def seen(self) -> tuple[int, Array]:
        """How many combinations of the values the data see, and (blind, values) those that they do not."""
        size, ways = np.linalg.eigh(self.curvature)
        blind = size <= BLIND * max(float(size[-1]), TINY)
        return int((~blind).sum()), ways[:, blind].T
