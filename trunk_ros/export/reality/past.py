"""Signals as they were a while ago."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.filters import delayed

ROWS = 32


class Past:
    """Hands a signal on ``delay`` (columns,) s late, by cubics as ``sensor_delay`` does."""

    def __init__(self, delay: Array):
        self._delay = delay
        self._longest = float(delay.max())
        self._stamps, self._rows = np.empty(ROWS), np.empty((ROWS, len(delay)))
        self._count = 0

    def step(self, now: float, x: Array) -> Array:
        """The signal (columns,) of ``delay`` before ``now`` s; before the first sample that one."""
        if self._count == len(self._stamps):
            self._make_room(now)
        self._stamps[self._count], self._rows[self._count] = now, x
        self._count += 1
        first = max(int(np.searchsorted(self._stamps[: self._count], now - self._longest)) - 2, 0)
        out: Array = np.empty((1, len(x)))
        seen = slice(first, self._count)
        delayed(self._stamps[seen], self._rows[seen], self._delay, self._count - first - 1, out)
        return np.asarray(out[0])

    def restart(self, which: np.ndarray, x: Array) -> None:
        """Let columns begin anew, as if they had always been at ``x`` (columns,)."""
        self._rows[: self._count, which] = x[which]

    def _make_room(self, now: float) -> None:
        """Forget what no delay reaches, or take twice the room."""
        first = max(int(np.searchsorted(self._stamps, now - self._longest)) - 3, 0)
        kept = self._count - first
        if first < len(self._stamps) // 2:
            self._stamps = np.concatenate([self._stamps, np.empty_like(self._stamps)])
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._stamps[:kept] = self._stamps[first : self._count].copy()
        self._rows[:kept] = self._rows[first : self._count].copy()
        self._count = kept
