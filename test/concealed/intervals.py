"""Intervals at 95 % for what the proof reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Z = 1.959964
ROUNDS = 1000


@dataclass(frozen=True)
class Estimate:
    """A value with its interval; ``n`` is what it rests on. Value NaN where n is 0."""

    value: float
    low: float
    high: float
    n: int

    def text(self, digits: int = 2) -> str:
        """``0.93 (0.88 … 0.96)``."""
        if not self.n:
            return "–"
        return f"{self.value:.{digits}f} ({self.low:.{digits}f} … {self.high:.{digits}f})"

    def told(self) -> dict[str, Any]:
        """For results.json; null in the place of NaN."""
        numbers = {"value": self.value, "low": self.low, "high": self.high}
        return {**{k: v if np.isfinite(v) else None for k, v in numbers.items()}, "n": self.n}


NOTHING = Estimate(float("nan"), float("nan"), float("nan"), 0)


def wilson(good: int, n: int) -> Estimate:
    """A proportion with Wilson's score interval."""
    if n == 0:
        return NOTHING
    share, over = good / n, 1 + Z * Z / n
    centre = (share + Z * Z / (2 * n)) / over
    half = Z * np.sqrt(share * (1 - share) / n + Z * Z / (4 * n * n)) / over
    return Estimate(share, max(0.0, float(centre - half)), min(1.0, float(centre + half)), n)


def bootstrap(some: Sequence[Any], statistic: Callable[[list[Any]], float]) -> Estimate:
    """A statistic of the sample with the percentile interval over resamples of its members."""
    if not some:
        return NOTHING
    rng = np.random.default_rng(0)
    picks = rng.integers(0, len(some), (ROUNDS, len(some)))
    values = np.array([statistic([some[i] for i in row]) for row in picks])
    low, high = np.nanpercentile(values, [2.5, 97.5])
    return Estimate(float(statistic(list(some))), float(low), float(high), len(some))
