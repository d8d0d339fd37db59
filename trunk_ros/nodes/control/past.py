"""What was wanted of the joints a while ago, since what is measured is always of the past."""

from __future__ import annotations

from bisect import bisect_left

import numpy as np

from trunk_ros.trajectory import Array

LEAST = 1000  # entries that are kept


class Past:
    """Rows of equal shape over time [s]."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._rows: list[Array] = []

    def add(self, now: float, row: Array) -> None:
        """Remember what holds at ``now``; what came later, before time was set back, is forgotten."""
        if self._times and now <= self._times[-1]:
            end = bisect_left(self._times, now)
            del self._times[end:], self._rows[end:]
        self._times.append(now)
        self._rows.append(row)
        if len(self._times) > 2 * LEAST:
            del self._times[:LEAST], self._rows[:LEAST]

    def at(self, time: float) -> Array:
        """The row of a time, straight between two entries; the first before all, the last after all.

        Raises IndexError where there is none.
        """
        after = bisect_left(self._times, time)
        if after in (0, len(self._times)) or self._times[after] == time:
            return self._rows[min(after, len(self._rows) - 1)]
        begin, end = self._times[after - 1], self._times[after]
        share = (time - begin) / (end - begin)
        return np.asarray((1 - share) * self._rows[after - 1] + share * self._rows[after])
