"""A bank of drags: each is taken along by a motion for a stretch and then slides (Prandtl-Ishlinskii)."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.bank import WEIGHTS, Bank
from trunk_ros.effects.effect import Regime

NARROWEST, WIDEST = 0.015, 0.4  # of the range of a source
SHORTEST = 1e-9  # rad


class Drags(Bank):
    """theta += sum of weight (s - play(s, reach)), reach in even ratios from ``low`` to ``high``."""

    regime: ClassVar[Regime] = "reversal"
    remembers = True

    @classmethod
    def ready(cls, low: float, high: float, weights: Array) -> tuple[Array, Array]:
        return np.geomspace(max(low, SHORTEST), max(high, SHORTEST), WEIGHTS), weights

    @classmethod
    def add(cls, s: Array, ready: tuple[Array, Array], state: Any, out: Array) -> Array:
        stuck = np.full(WEIGHTS, s[0]) if state is None else state.copy()
        drag(s, *ready, stuck, out)
        return stuck

    @classmethod
    def swing(cls, low: float, high: float) -> tuple[float, float]:
        return -high, high

    @classmethod
    def range_of(cls, s: Array) -> tuple[float, float]:
        return NARROWEST * float(np.ptp(s)), WIDEST * float(np.ptp(s))


@compiled
def drag(s: Array, reach: Array, weights: Array, stuck: Array, out: Array) -> None:
    """Add to ``out`` (n,) what each play of a half-width ``reach`` (k,) holds back of ``s`` (n,), times its
    weight; ``stuck`` (k,) changes in place.
    """
    for k in range(len(reach)):
        at = stuck[k]
        for i in range(len(s)):
            at = min(max(at, s[i] - reach[k]), s[i] + reach[k])
            out[i] += weights[k] * (s[i] - at)
        stuck[k] = at
