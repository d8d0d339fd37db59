"""Joints that see each other: a computation is repeated until it agrees with itself."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.stage import State

PASSES = 30  # joints that drag each other are computed until they agree
AGREED = 1e-7  # rad, a hundredth of what an encoder tells
LEAST_SLOPE = 0.3  # of a line that is gone by
CALMEST = 0.002  # a pass never counts for less of the one before


class Passes:
    """Repeats a computation until its result no longer changes what it was computed from."""

    def __init__(self, state: State | None, agreed: float = AGREED):
        """``agreed``: rad that the next pass may change."""
        self._agreed = agreed
        self.calm = state.calm if state else 1.0
        self._change = 0.0
        self._left = PASSES
        self._before: tuple[Array, Array] | None = None

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

    def onward(self, better: Array, before: Array) -> Array:
        """What to compute from next (n, joints) rad: where a line through the last two passes has a joint
        agree with itself, since a result may change by many times what it was computed from; ``better``
        where there is no such line.
        """
        off = before - better
        out = better
        if self._before is not None:
            moved, changed = before - self._before[0], off - self._before[1]
            known = changed * moved > LEAST_SLOPE * moved**2
            out = np.where(known, before - off * moved / np.where(known, changed, 1.0), better)
        self._before = before, off
        return out
