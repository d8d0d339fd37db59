"""Readings of a sensor that is slower than its topic: each is repeated until the next one comes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.levels import CLEARLY, FEWEST, NEARLY, OUTLIERS, PART, THREEFOLD
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.encoder import EVEN


def holding(stamp: Array, values: Array) -> float:
    """Usual time [s] for which a sensor holds each of its readings (n,); 0 where every sample is a new
    one.

    The steps that are much larger than the smallest give the clock's period, and nearly all steps come after
    whole periods. An encoder that goes so far from one sample to the next changes at every sample, and where
    it is slow it waits for as long as the way to the next count takes.
    """
    new = np.flatnonzero(np.diff(values)) + 1
    if len(new) < FEWEST:
        return 0.0
    apart, steps = np.diff(stamp[new]), np.abs(np.diff(values)[new - 1])[1:]
    tick = float(np.median(np.diff(stamp)))
    low, high = np.quantile(steps, (0.1, 0.9))
    if high <= THREEFOLD * low:
        return 0.0
    within = (1.0 + EVEN) * tick  # what comes evenly is published at one of two ticks
    usual = float(np.median(apart[steps > THREEFOLD * low]))
    near = np.abs(apart - usual) <= within
    if np.mean(near) <= PART:
        return 0.0
    usual = float(np.mean(apart[near]))
    whole = usual * np.maximum(np.rint(apart / usual), 1.0)
    clocked = float(np.mean(np.abs(apart - whole) <= within)) >= NEARLY
    return usual if clocked and usual > CLEARLY * tick else 0.0


def asked(stamp: Array, usual: float, tick: float) -> Array:
    """Times (n,) s at which a sensor was read, about every ``usual`` s, whose readings are published at the
    next ``tick``, at ``stamp`` (n,): they wait up to a whole one, which looks like a lag that wanders.

    The last moments that the stamps allow, evenly apart; a constant age beyond that cannot be seen in them.
    The stamps where no even reading explains them, or where they are even already.
    """
    apart = np.diff(stamp)
    mean = float(np.mean(apart[apart < CLEARLY * usual]))
    number = np.concatenate([[0.0], np.cumsum(np.maximum(np.rint(apart / mean), 1.0))])
    period, begin = np.polyfit(number, stamp, 1)
    waits = stamp - begin - period * number
    # the first one, and one after a rest, may be old
    low, high = np.quantile(waits, [OUTLIERS, 1.0 - OUTLIERS])
    if not EVEN * tick < high - low < (1.0 + EVEN) * tick:
        return stamp
    out = stamp - np.clip(waits - low, 0.0, tick)
    return np.asarray(out) if (np.diff(out) > 0.0).all() else stamp


def new_readings(series: JointSeries) -> tuple[JointSeries, float]:
    """The series without repeats, and how long [s] its sensor holds a reading; 0 where it does not.

    All joints that move have to be held: they are read together. While nothing changes one sample is kept
    every other reading, since standing still is a fact as well.
    """
    read = series.position[:, np.isfinite(series.position).any(axis=0)]  # a dead sensor tells nothing
    known = np.isfinite(read).all(axis=1)
    stamp, position = series.stamp[known], read[known]
    moving = [j for j in range(position.shape[1]) if np.ptp(position[:, j]) > 0.0] if len(stamp) else []
    times = [holding(stamp, position[:, j]) for j in moving]
    if not times or min(times) == 0.0:
        return series, 0.0
    usual = float(np.median(times))
    new = series.rows(_kept(series.stamp, series.position, 2.0 * usual))
    return replace(new, stamp=asked(new.stamp, usual, float(np.median(np.diff(stamp))))), usual


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
    if len(steps) < FEWEST or len(np.unique(seen)) > PART * len(seen):
        return 0.0
    return float(np.median(steps) / np.sqrt(12.0))
