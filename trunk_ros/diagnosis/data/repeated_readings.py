"""Readings of a sensor that is slower than its topic: each is repeated until the next one comes."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.recording.recording import JointSeries

REPEATED = 1.5  # samples a reading: from here on some are repeats
REGULAR = 0.5  # of the usual time between readings: the shortest, where a clock and not the motion sets it
VARIED = 3.0  # longest over shortest step between readings: the steps of a coarse sensor are all alike
MANY = 20  # readings that it takes to tell
FEW = 0.1  # different values per reading, where a sensor is coarse
ROOT_12 = np.sqrt(12.0)


def holding(stamp: Array, values: Array) -> float:
    """Usual time [s] for which a sensor holds each of its readings (n,); 0 where every sample is a new
    one.
    """
    new = np.flatnonzero(np.diff(values)) + 1
    if len(new) < MANY:
        return 0.0
    apart, steps = np.diff(stamp[new]), np.abs(np.diff(values)[new - 1])
    usual = float(np.median(apart))
    low, high = np.quantile(steps, (0.1, 0.9))
    clocked = np.quantile(apart, 0.1) > REGULAR * usual and high > VARIED * low
    return usual if clocked and usual > REPEATED * np.median(np.diff(stamp)) else 0.0


def new_readings(series: JointSeries) -> tuple[JointSeries, float]:
    """The series without repeats, and how long [s] its sensor holds a reading; 0 where it does not.

    All joints that move have to be held: they are read together. While nothing changes one sample is kept
    every other reading, since standing still is a fact as well.
    """
    known = np.isfinite(series.position).all(axis=1)
    stamp, position = series.stamp[known], series.position[known]
    moving = [j for j in range(position.shape[1]) if np.ptp(position[:, j]) > 0.0] if len(stamp) else []
    times = [holding(stamp, position[:, j]) for j in moving]
    if not times or min(times) == 0.0:
        return series, 0.0
    usual = float(np.median(times))
    return series.rows(_kept(series.stamp, series.position, 2.0 * usual)), usual


def _kept(stamp: Array, position: Array, longest: float) -> np.ndarray:
    """(n,) where a reading is new, or the last one that was kept is ``longest`` [s] ago."""
    out = np.ones(len(stamp), dtype=bool)
    out[1:] = np.any((position[1:] != position[:-1]) & np.isfinite(position[1:]), axis=1)
    last = stamp[0]
    for k in range(len(stamp)):
        out[k] |= stamp[k] - last >= longest
        last = stamp[k] if out[k] else last
    return out


def coarseness(values: Array, valid: np.ndarray) -> float:
    """Standard deviation that a coarse sensor's steps add to its readings (n,); 0 where it is not coarse."""
    seen = values[valid]
    steps = np.abs(np.diff(seen))
    steps = steps[steps > 0.0]
    if len(steps) < MANY or len(np.unique(seen)) > FEW * len(seen):
        return 0.0
    return float(np.median(steps) / ROOT_12)
