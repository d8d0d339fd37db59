"""What waves of nearly one frequency share with signals, from sums over stretches of time: none of them is as
long as the recording.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np

from trunk_ros.compiled import Array

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
    def of(stamp: Array, middle: float, *signals: Array) -> Band:
        """Of signals (n, some) each, after one another, at rising stamps (n,)."""
        half = max(float(stamp[-1] - stamp[0]) / (2 * PIECES), 1e-9)
        cell = np.minimum((stamp - stamp[0]) / (2 * half), PIECES - 1).astype(int)
        starts = np.flatnonzero(np.diff(cell, prepend=-1))
        centres = stamp[0] + (2 * cell[starts] + 1) * half
        sums = np.empty((len(starts), ORDERS, sum(some.shape[1] for some in signals)), dtype=complex)
        order = np.arange(ORDERS)
        shares = np.array([1.0 / factorial(k) for k in order])
        for k, (first, end) in enumerate(zip(starts, [*starts[1:], len(stamp)], strict=True)):
            time = stamp[first:end, None]
            powers = ((time - centres[k]) / half) ** order * shares
            turn = 2.0 * np.pi * middle * time
            cosine, sine = (np.cos(turn) * powers).T, (np.sin(turn) * powers).T
            sums[k].real = np.hstack([cosine @ some[first:end] for some in signals])
            sums[k].imag = np.hstack([sine @ some[first:end] for some in signals])
        return Band(middle, half, centres, sums)

    def at(self, frequency: float) -> Array:
        """(2, signals): sums of each signal times cosine and times sine of a frequency [Hz] near the
        middle.
        """
        off = 2j * np.pi * (frequency - self.middle)
        along = np.exp(off * self.centres)[:, None] * (off * self.half) ** np.arange(ORDERS)
        found = np.tensordot(along, self.sums, 2)
        return np.array([found.real, found.imag])
