"""Joints that see each other: a computation is repeated until it agrees with itself."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.stage import State

PASSES = 30  # joints that drag each other are computed until they agree
AGREED = 1e-7  # rad, a hundredth of what an encoder tells
CALMEST = 0.002  # a pass never counts for less of the one before


class Passes:
    """Repeats a computation until its result no longer changes what it was computed from."""

    def __init__(self, state: State | None, agreed: float = AGREED):
        """``agreed``: rad that the next pass may change."""
        self._agreed = agreed
        self.calm = state.calm if state else 1.0
        self._change = 0.0
        self._left = PASSES

    def agree(self, better: Array, before: Array, besides: float = 0.0) -> bool:
        """Whether the next pass would change less than was agreed, going by how the changes shrank so far.
        Both (n, joints) rad.

        ``besides``: rad that changed elsewhere.
        """
        change = max(float(np.abs(better - before).max()), besides)
        if self._change > 0.0:
            self.calm = min(max(change / self._change, CALMEST), 1.0)
        self._change = change
        self._left -= 1
        return self.calm * change < self._agreed or not self._left
