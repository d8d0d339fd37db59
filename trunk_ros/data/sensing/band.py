"""What waves of nearly one frequency share with signals, from sums over stretches of time: none of them is as
long as the recording.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.sensing.physics import Features
from trunk_ros.machine import PIECE

PIECES = 256
ORDERS = 12  # of a wave's course within one: of waves within 16 turns of the middle the rest is rounding


@dataclass(frozen=True)
class Band:
    """Sums over the stretches of signals times exp(i w t) times powers of the time since a stretch's middle,
    w that of the band's ``middle`` Hz.
    """

    middle: float
    half: float
    """Half the length of a stretch [s]."""
    centres: Array
    """(stretches,) s."""
    sums: Array
    """(stretches, ORDERS, signals), complex."""

    @staticmethod
    def of(stamp: Array, middle: float, *signals: Array | Features) -> Band:
        """Of signals (n, some) each, after one another, at rising stamps (n,)."""
        half = max(float(stamp[-1] - stamp[0]) / (2 * PIECES), 1e-9)
        cell = np.minimum((stamp - stamp[0]) / (2 * half), PIECES - 1).astype(int)
        starts = np.flatnonzero(np.diff(cell, prepend=-1))
        centres = stamp[0] + (2 * cell[starts] + 1) * half
        ends = [*starts[1:].tolist(), len(stamp)]
        longest = max(end - start for start, end in zip(starts.tolist(), ends, strict=True))
        many = max(PIECE // longest, 1)
        sums = []
        for k in range(0, len(starts), many):
            rows = slice(int(starts[k]), ends[min(k + many, len(ends)) - 1])
            which = np.searchsorted(starts[k : k + many], np.arange(rows.start, rows.stop), side="right") - 1
            off = (stamp[rows] - centres[k + which]) / half
            waves = np.exp(2j * np.pi * middle * stamp[rows])
            place = which, np.arange(rows.start, rows.stop) - starts[k + which]
            sums.append(_summed(off, waves, place, longest, [some[rows] for some in signals]))
        return Band(middle, half, centres, np.concatenate(sums))

    def at(self, frequency: float) -> Array:
        """(2, signals): sums of each signal times cosine and times sine of a frequency [Hz] near the
        middle.
        """
        off = 2j * np.pi * (frequency - self.middle)
        along = np.exp(off * self.centres)[:, None] * (off * self.half) ** np.arange(ORDERS)
        found = np.tensordot(along, self.sums, 2)
        return np.array([found.real, found.imag])


def _summed(
    off: Array,
    waves: np.ndarray,
    place: tuple[np.ndarray, np.ndarray],
    longest: int,
    signals: Sequence[Array],
) -> np.ndarray:
    """(stretches, ORDERS, signals): sums over stretches of ``waves`` (n,) complex times powers of the time
    ``off`` (n,) their middle, over factorials, times signals (n, some) each; ``place``: (n,) which stretch a
    row is in, and where, of ``longest`` at most.
    """
    shape = int(place[0][-1]) + 1, longest
    powers = np.zeros((ORDERS, *shape), dtype=complex)
    for order, power in enumerate(powers):
        power[place] = waves
        waves = waves * off / (order + 1)
    each = np.zeros((*shape, sum(some.shape[1] for some in signals)))
    each[place] = np.concatenate(signals, axis=1)
    out = np.empty((shape[0], ORDERS, each.shape[2]), dtype=complex)
    out.real, out.imag = (part.transpose(1, 0, 2) @ each for part in (powers.real, powers.imag))
    return out
