"""The curve of a shaft through its readings: cubic, but it does not swing where the readings do not."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from trunk_ros.recording.recording import Floats


def slopes(t: Floats, position: Floats, velocity: Floats | None) -> Floats:
    """(n,) slope at each of (n,) stamps: the measured velocity, or a spline's, as far as readings bear out.

    A spline swings about each corner, past the place where a shaft stops, by up to 8 % of what it goes from
    one reading to the next; a velocity that is late goes on as well. Friction keeps the wire there. Huynh's
    limits (1993), SIAM J. Numer. Anal. 30(1), leave a smooth curve, with its turns, as it is.
    """
    slope: Floats = CubicSpline(t, position)(t, 1) if velocity is None else velocity.copy()
    gaps = np.diff(t)
    secants = np.diff(position) / gaps
    bends = np.zeros_like(position)
    bends[1:-1] = np.diff(secants) / (t[2:] - t[:-2])
    if len(t) > 3:  # at both ends it bends as it goes on
        bends[0], bends[-1] = bends[2], bends[-3]
    bend = _lesser(bends[:-1], bends[1:]) * gaps
    curved, straight = _at(secants + bend, secants - bend), _at(secants, secants)
    up = np.sign(np.where(curved != 0.0, curved, straight))
    most = np.maximum(3.0 * np.abs(straight), 1.5 * np.abs(curved))
    return up * np.clip(up * slope, 0.0, most)


def _at(arrives: Floats, leaves: Floats) -> Floats:
    """(n,) at each reading, of what (n - 1,) curves between them arrive with and leave with: the lesser."""
    return _lesser(np.concatenate([leaves[:1], arrives]), np.concatenate([leaves, arrives[-1:]]))


def _lesser(a: Floats, b: Floats) -> Floats:
    """The smaller of two, 0 where they differ in sign."""
    return np.where(a * b > 0.0, np.where(np.abs(a) < np.abs(b), a, b), 0.0)
