"""Joints that see each other: a computation is repeated until it agrees with itself."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.stage import State

PASSES = 30  # joints that drag each other are computed until they agree
AGREED = 1e-7  # rad, a hundredth of what an encoder tells
LEAST_SLOPE = 0.3  # of a line that is gone by
UNKNOWN = np.array([[-np.inf], [np.inf], [np.nan], [np.inf]])  # how far, and the last try
TRIES = 60  # each two halve what a joint is off, or where it may lie
SEARCHES = 6  # after which what else changes with the gearbox finds its speed as it is
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


class Crossing:
    """Where each joint comes out as it was put in, also where a little more that goes in has much less come
    out. What a joint is off, the one less the other, is below 0 before the crossing and above it behind.
    """

    def __init__(self, guess: Array, stood: Array, towards: Array, slope: Array | None, agreed: float):
        """``stood`` (columns,): beyond it, against the way ``towards`` which a joint is to go, lie others,
        which are no way on. ``slope`` (columns,): how what a joint is off changed with what was put in, the
        last time; ``agreed``: rad that it may be off.
        """
        self.at = np.empty_like(guess)
        outset(guess, stood, towards, self.at)
        self._stood, self._agreed = stood, agreed
        self._left, self._searches = TRIES, SEARCHES
        self.slope = slope
        self._known: Array | None = None

    def anew(self) -> None:
        """Forget the tries, as something else changed what comes out."""
        self._searches -= 1
        self._known, self._left = None, TRIES if self._searches > 0 else 0

    def found(self, better: Array) -> bool:
        """Whether all joints come out, ``better``, as put in, or enough was tried; otherwise ``at`` becomes
        what to try next.
        """
        if not self._left:
            return True
        self._left -= 1
        if self._known is None:
            self._known = UNKNOWN + np.zeros_like(better)
            self.slope = np.ones_like(better) if self.slope is None else self.slope.copy()
        assert self.slope is not None
        off = self.at - better
        return onward(self.at, off, self._stood, self._agreed, self.slope, self._known)


@compiled
def outset(guess: Array, stood: Array, towards: Array, at: Array) -> None:
    """Where to begin (columns,): at the guess where that is ahead."""
    for j in range(len(at)):
        at[j] = guess[j] if (guess[j] - stood[j]) * towards[j] > 0.0 else stood[j]


@compiled
def onward(at: Array, off: Array, stood: Array, agreed: float, slope: Array, known: Array) -> bool:
    """Where a line says, if each halves what a joint is off and stays between the tries on either side; the
    middle of these else. ``known`` (4, columns): both sides, and the last try.
    """
    found = True
    for j in range(len(at)):
        x, e = at[j], off[j]
        if abs(e) < agreed:
            continue
        found = False
        known[0 if e < 0.0 else 1, j] = x
        low, high, last, more = known[0, j], known[1, j], known[2, j], known[3, j]
        if more < np.inf:
            slope[j] = max((e - more) / (x - last), LEAST_SLOPE)
        to = x - e / slope[j]
        if abs(e) > abs(more) / 2.0 or not low < to < high:
            to = (low + high) / 2.0 if high - low < np.inf else x - e
        if low < stood[j] < high and (to - stood[j]) * (x - stood[j]) < 0.0:
            to = stood[j]
        at[j], known[2, j], known[3, j] = to, x, e
    return found
