"""Friction elements of different kinds on the joints of one arm, or one after the other."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.wire.play import SharpPlay


class Elements:
    """One friction element on some columns or for a time, another one else: each runs on all of them, all the
    time, and keeps its own memory.
    """

    def __init__(self, first: Any, second: Any, of_second: np.ndarray):
        """``of_second`` (columns,) or (n, columns): how much the second counts."""
        self.first, self.second, self.of_second = first, second, of_second

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.run; state: those of both."""
        before = (None, None) if state is None else state
        one, memory = self.first.run(u, width, before[0])
        two, other = self.second.run(u, width, before[1])
        return self._of_both(one, two), (memory, other)

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.invert."""
        before = (None, None) if state is None else state
        one, memory = self.first.invert(y, width, before[0])
        two, other = self.second.invert(y, width, before[1])
        return self._of_both(one, two), (memory, other)

    def _of_both(self, one: Array, two: Array) -> Array:
        share = self.of_second
        if share.ndim == 1:
            return np.where(share, two, one)
        share = share if len(share) == len(one) else share[:1]  # places alone, before the first step
        return np.asarray(one + share * (two - one))


def beside(there: Any, element: Any, columns: np.ndarray) -> Any:
    """An ``element`` on some ``columns`` (columns,), and what is ``there`` on the others: None for a sharp
    play on all.
    """
    if not columns.any():
        return there
    return element if columns.all() else Elements(there or SharpPlay(), element, columns)
