"""One stage of one recording on one time grid."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.bursts import Burst
from trunk_ros.data.revisited import neighbours
from trunk_ros.resistance import Resistance


@dataclass(frozen=True)
class Span:
    """One stage of one recording. ``grid`` (m,) is where the model is computed, ``rows`` (n,) which of it
    was measured.

    ``source`` (m, joints) is the input, ``target`` (n, joints) what was measured, ``valid`` (n, joints) what
    counts.
    """

    name: str
    joints: tuple[str, ...]
    grid: Array
    source: Array
    velocity: Array
    rows: np.ndarray
    target: Array
    valid: np.ndarray
    gearbox: Array
    start: tuple[np.ndarray, ...]
    """Rows of the target at which each joint stands as it began; none where that is not known."""
    resistance: Resistance | None = None
    """What the recording tells of the load, where the model takes it from there."""
    held: float = 0.0
    """Time [s] for which the sensor of the target repeats each reading; the repeats are left out."""
    counts: Array | None = None
    """(joints,) rad of the gearbox per step of its encoder, 0 where readings lie on no grid; more where noise
    scatters them more than such steps."""
    shown: Array | None = None
    """(joints,) rad from one reading of a joint's own encoder to the next, 0 where they lie on no grid."""
    before: int = 0
    """Rows of the grid that stand for what moved before the recording, at the time of its first sample."""
    arrives: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=int))
    """Rows of the grid that stand for how the drives came to the stop of the row after."""
    counting: tuple[Array, ...] = ()
    """(joints,) shares of the readings that still count after each of the reasons in ``counting.WHY``."""
    unsure: tuple[float, float] = (0.0, 0.0)
    """Standard deviations of how fast the target's clock runs [s/s] and how far ahead it is [s], where that
    was found to be otherwise than its stamps had it."""
    early: np.ndarray | None = None
    """(n, joints): what counts as well once it is told how wide loops lay as the recording began."""
    pace: tuple[float, float] = (0.0, 0.0)
    """By how much it is taken to run faster [s/s] and to be further ahead [s] than it was found to."""
    knocks: tuple[tuple[int, float], ...] = ()
    """Columns and moments [s]: a joint that rests is moved there within its dead band, by what shakes it."""
    bursts: tuple[Burst, ...] = ()
    """In which most sensors are louder."""
    anew: Array = field(default_factory=lambda: np.zeros(0))
    """(k,) s: when servos begin anew from what was read of them, as their setpoints before are not known."""
    lost: tuple[Array, ...] = ()
    """Of each joint (k, 2) s between which nobody saw its motor; none at all where it is seen at stops."""
    unseen: float = 0.0
    """How much faster or slower [s/s] it may run without that it shows before the physics is known."""

    def __post_init__(self) -> None:
        """Columns lie in memory by themselves: those of one joint are no copies then."""
        source, gearbox = self.source, self.gearbox
        for name in ("source", "velocity", "target", "valid"):
            object.__setattr__(self, name, np.asfortranarray(getattr(self, name)))
        object.__setattr__(self, "gearbox", self.source if gearbox is source else np.asfortranarray(gearbox))

    @cached_property
    def stamp(self) -> Array:
        """(n,) s, of the measured rows."""
        return np.asarray(self.measured(self.grid))

    @cached_property
    def neighbours(self) -> np.ndarray:
        """(n,) the measured row at the place nearest to that of each."""
        return neighbours(self.measured(self.source))

    @cached_property
    def loud(self) -> Array | None:
        """(n,) times as loud as usual, where bursts are."""
        if not self.bursts:
            return None
        out = np.ones(len(self.stamp))
        for begin, end, times in self.bursts:
            out[(self.stamp >= begin) & (self.stamp <= end)] = times
        return out

    def measured(self, signal: Array) -> Array:
        """(n,) of a signal (m,) on the grid, at the measured rows."""
        rows = self._rows
        return signal[rows] if isinstance(rows, slice) else signal.take(rows, axis=0)

    @cached_property
    def _rows(self) -> np.ndarray | slice:
        return in_one_piece(self.rows)

    @property
    def late(self) -> np.ndarray:
        """(n, joints): what counts, however the joints lay at first."""
        return self.valid if self.early is None else self.valid & ~self.early

    @property
    def recorded(self) -> np.ndarray:
        """(k,) rows of the grid that stand for a time of their own."""
        return np.delete(np.arange(self.before, len(self.grid)), self.arrives - self.before)


def in_one_piece(rows: np.ndarray) -> np.ndarray | slice:
    """Rows (n,), as a slice where they are one: it takes no copy."""
    first, last = (int(rows[0]), int(rows[-1])) if len(rows) else (0, -1)
    return slice(first, last + 1) if np.array_equal(rows, np.arange(first, last + 1)) else rows
