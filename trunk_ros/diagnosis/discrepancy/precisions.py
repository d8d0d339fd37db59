"""How large weights in groups are, by marginal likelihood: what linear fits of banks are made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dtrmm
from scipy.linalg.lapack import dpotrf, dpotrs, dtrtri, dtrtrs

from trunk_ros.compiled import Array
from trunk_ros.guards import ROUNDED, ROUNDS, TINY
from trunk_ros.levels import PART

PRECISIONS = (1e-3, 1e8)


@dataclass(frozen=True)
class Total:
    """What a linear fit needs of a residual and of all sources' designs: X^T X (k, k), X^T y (k,), y^T y and
    the number of rows.
    """

    normal: Array
    side: Array
    power: float
    count: float

    def of(self, at: np.ndarray, worth: float) -> Total:
        """Of the columns at some places; ``worth`` rows count as one."""
        normal, side = self.normal[np.ix_(at, at)] / worth, self.side[at] / worth
        return Total(normal, side, self.power / worth, self.count / worth)

    def left(self, at: np.ndarray, weights: Array) -> float:
        """Power that weights (of columns at some places,) leave."""
        there = self.normal[np.ix_(at, at)] @ weights - 2.0 * self.side[at]
        return self.power + float(weights @ there)


@dataclass(frozen=True)
class Weighed:
    """Weights (k,), the precision of each of their groups, and that of the noise."""

    weights: Array
    precision: Array
    sharp: float


def weighed(total: Total, sizes: Sequence[int], begun: Weighed | None = None) -> Weighed:
    """Weights in groups of some sizes, each with a precision of its own, of the largest marginal likelihood
    (MacKay 1992, Neural Computation 4(3)); looked for from a fit that has ``begun``. No shape adds much more
    than there is to explain: large ones that cancel where they were seen add up elsewhere.
    """
    normal, side, power, count = total.normal, total.side, total.power, total.count

    def sharper(weights: Array, told: float) -> float:
        rest = power - 2.0 * float(weights @ side) + float(weights @ normal @ weights)
        return max(count - told, 0.1 * count) / max(rest, TINY)

    if begun is None:
        begun = Weighed(np.empty(0), np.ones(len(sizes)), count / max(power, TINY))
    return _in_turns(normal, side, _least(total), sizes, begun, sharper)


def _in_turns(
    normal: Array, side: Array, least: Array, sizes: Sequence[int], begun: Weighed,
    sharper: Callable[[Array, float], float],
) -> Weighed:  # fmt: skip
    """Weights and precisions in turn, from those that have ``begun``; ``sharper``: the precision of the noise
    by weights and how many of them are told.
    """
    of, weights = np.repeat(np.arange(len(sizes)), sizes), np.zeros_like(side)
    precision, sharp = begun.precision, begun.sharp
    for _ in range(ROUNDS):
        own = precision[of] + least
        factor = _factor(sharp * normal, own)
        weights = sharp * np.asarray(dpotrs(factor, side, lower=1)[0])
        told = sizes - np.bincount(of, own * _spread(factor), len(sizes))
        size = np.maximum(np.bincount(of, weights**2, len(sizes)), TINY)
        before, precision = precision, np.clip(told / size, *PRECISIONS)
        sharp = sharper(weights, float(told.sum()))
        if np.abs(np.log(precision / before)).max() < PART:
            break
    return Weighed(weights, precision, sharp)


class Beside:
    """What further columns would do beside columns whose precisions, and that of the noise, stay as they are:
    a look that costs little.
    """

    def __init__(self, total: Total, sizes: Sequence[int], there: Weighed):
        """``total``: with those of ``there`` first."""
        many, sharp = sum(sizes), there.sharp
        self.total, self.there, self.many, self.least = total, there, many, _least(total)
        own = np.repeat(there.precision, sizes) + self.least[:many]
        self.factor = _factor(sharp * total.normal[:many, :many], own)
        self.across = np.asarray(dtrtrs(self.factor, sharp * total.normal[:many, many:], lower=1)[0])
        self.along = np.asarray(dtrtrs(self.factor, sharp * total.side[:many], lower=1)[0])

    def weighed(self, first: int, last: int, sizes: Sequence[int]) -> Weighed:
        """With some of the further columns, in groups of some sizes."""
        total, sharp, along, across = self.total, self.there.sharp, self.along, self.across[:, first:last]
        at = slice(self.many + first, self.many + last)
        inside = sharp * total.normal[at, at] - across.T @ across
        side = sharp * total.side[at] - across.T @ along
        begun = Weighed(np.empty(0), np.ones(len(sizes)), 1.0)
        new = _in_turns(inside, side, self.least[at], sizes, begun, lambda *_: 1.0)
        old = np.asarray(dtrtrs(self.factor, along - across @ new.weights, lower=1, trans=1)[0])
        weights = np.concatenate([old, new.weights])
        return Weighed(weights, np.concatenate([self.there.precision, new.precision]), sharp)


def _least(total: Total) -> Array:
    return np.asarray(np.diag(total.normal) / max(total.power, TINY))


def _factor(matrix: Array, own: Array) -> Array:
    """Lower triangle (k, k) of a positive matrix with more on its diagonal, which it is overwritten with."""
    diagonal = np.einsum("ii->i", matrix)
    diagonal += own
    diagonal += ROUNDED * float(diagonal.sum()) / len(diagonal)
    return np.asarray(dpotrf(matrix.T, lower=1, overwrite_a=1, clean=1)[0])


def _spread(factor: Array) -> Array:
    """(k,) diagonal of the inverse of a matrix with a lower triangle; by halves, as products of blocks take
    half of the time that the inverse of a triangle does.
    """
    half = len(factor) // 2
    if not half:
        return np.asarray(factor[0] ** -2.0)
    first, last = (dtrtri(part, lower=1)[0] for part in (factor[:half, :half], factor[half:, half:]))
    across = dtrmm(1.0, first, dtrmm(1.0, last, factor[half:, :half], lower=1), side=1, lower=1)
    squares = [np.einsum("ij,ij->j", part, part) for part in (first, across, last)]
    return np.concatenate([squares[0] + squares[1], squares[2]])
