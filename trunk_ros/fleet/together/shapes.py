"""Shapes that a series over time may have: constant, growing, growing since some day, jumping.

Each is a linear model with a few columns; days of change are searched, and their search is paid for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import ruptures
from ruptures.base import BaseCost

from trunk_ros.compiled import Array

SEGMENT = 2  # recordings on each side of a change
STEPS = 4  # changes of one series
PLACES = 200  # where changes are looked for in a long series


@dataclass(frozen=True)
class Shape:
    """A fit. ``columns`` (n, k): what it is made of, the constant first; ``places``: first recordings after
    a change; ``tried``: how many shapes of its kind were tried, which its chance has to answer for.
    """

    kind: str
    columns: Array
    places: tuple[int, ...]
    tried: int
    coefficients: Array
    covariance: Array
    """(k, k) for unit variance of the weighted residuals."""
    rest: float
    """Sum of squared weighted residuals."""

    @property
    def dof(self) -> int:
        """Degrees of freedom that are left."""
        return int(len(self.columns) - self.columns.shape[1] - len(self.places))

    @property
    def fitted(self) -> Array:
        """(n,) in the series' own unit."""
        return np.asarray(self.columns @ self.coefficients)


def fitted(
    kind: str, columns: Array, value: Array, sigma: Array, places: tuple[int, ...], tried: int
) -> Shape:
    """Weighted least squares of ``value`` (n,) with deviations in the ratio of ``sigma`` (n,)."""
    weighted = columns / sigma[:, None]
    inverse = np.linalg.pinv(weighted.T @ weighted)
    found: Array = inverse @ (weighted.T @ (value / sigma))
    rest = float(np.sum(((value - columns @ found) / sigma) ** 2))
    return Shape(kind, columns, places, tried, found, np.asarray(inverse, dtype=float), rest)


def constant(value: Array, sigma: Array) -> Shape:
    """One value for all recordings."""
    return fitted("constant", np.ones((len(value), 1)), value, sigma, (), 1)


def line(x: Array, value: Array, sigma: Array) -> Shape:
    """A value that grows in proportion to ``x`` (n,)."""
    return fitted("line", np.column_stack([np.ones(len(x)), x - x[-1]]), value, sigma, (), 1)


def bend(x: Array, value: Array, sigma: Array) -> Shape | None:
    """A constant that grows from some recording on; None where there are too few of them."""
    places = candidates(len(x), SEGMENT)
    best: Shape | None = None
    for place in places:
        grown = np.maximum(x - x[place - 1], 0.0)
        there = fitted("bend", np.column_stack([np.ones(len(x)), grown]), value, sigma, (place,), len(places))
        if best is None or there.rest < best.rest:
            best = there
    return best


def jumps(value: Array, sigma: Array, scale: float) -> Shape | None:
    """Constants between changes (PELT of ruptures); None where no change pays.

    ``scale``: variance of the weighted residuals that is noise.
    """
    n = len(value)
    if n < 2 * SEGMENT:
        return None
    search = ruptures.Pelt(custom_cost=_Weighted(sigma), min_size=SEGMENT, jump=max(1, n // PLACES))
    ends = search.fit(value[:, None]).predict(pen=price(n, 3) * scale)
    places = tuple(_nearest(value, sigma, ends, k) for k in range(len(ends) - 1))
    if not 0 < len(places) <= STEPS:
        return None
    steps = [(np.arange(n) >= place).astype(float) for place in places]
    return fitted("jumps", np.column_stack([np.ones(n), *steps]), value, sigma, places, n - 2 * SEGMENT + 1)


def without(shape: Shape, row: int, value: Array, sigma: Array) -> Shape:
    """The same shape fitted without one recording."""
    keep = np.arange(len(value)) != row
    return fitted(shape.kind, shape.columns[keep], value[keep], sigma[keep], shape.places, shape.tried)


def _nearest(value: Array, sigma: Array, ends: list[int], k: int) -> int:
    """The best first recording after the k-th change, between those beside it: a long series was searched
    in strides.
    """
    low, high = (ends[k - 1] if k else 0), ends[k + 1]
    tried = range(low + SEGMENT, high - SEGMENT + 1)
    return int(
        tried[int(np.argmin([_cost(value, sigma, low, p) + _cost(value, sigma, p, high) for p in tried]))]
    )


def _cost(value: Array, sigma: Array, start: int, end: int) -> float:
    weight = 1.0 / sigma[start:end] ** 2
    part = value[start:end]
    return float(weight @ (part - weight @ part / weight.sum()) ** 2)


def candidates(n: int, least: int) -> list[int]:
    """Places of a change among n recordings with at least so many on each side."""
    return sorted({int(p) for p in np.linspace(least, n - least, PLACES)}) if n >= 2 * least else []


def price(n: int, values: int) -> float:
    """What a shape with so many values more has to gain in squared unit noise (Schwarz)."""
    return values * float(np.log(max(n, 2)))


class _Weighted(BaseCost):  # type: ignore[misc]
    """Squared deviations from the weighted mean of a segment, from sums that are made once."""

    model = "weighted"
    min_size = 1

    def __init__(self, sigma: Array):
        self._weight = 1.0 / sigma**2

    def fit(self, signal: Array) -> Any:
        """Prepare for a signal (n, 1)."""
        self.signal = signal
        w, y = self._weight, signal[:, 0] - np.mean(signal)
        self._sums = [np.concatenate([[0.0], np.cumsum(part)]) for part in (w, w * y, w * y * y)]
        return self

    def error(self, start: int, end: int) -> float:
        """Cost of the segment start:end."""
        w, wy, wyy = (float(part[end] - part[start]) for part in self._sums)
        return max(wyy - wy * wy / w, 0.0)
