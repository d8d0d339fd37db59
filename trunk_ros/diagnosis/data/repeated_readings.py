"""Readings of a sensor that is slower than its topic: each is repeated until the next one comes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.levels import CLEARLY, FEWEST, HALF, NEARLY, OUTLIERS, PART, THREEFOLD
from trunk_ros.recording.child_process import at_stamps
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.encoder import EVEN


def holding(stamp: Array, values: Array) -> float:
    """Usual time [s] for which a sensor holds each of its readings (n,); 0 where every sample is a new
    one.

    The steps that are much larger than the smallest give the clock's period, and nearly all steps come after
    whole periods. An encoder that goes so far from one sample to the next changes at every sample, and where
    it is slow it waits for as long as the way to the next count takes.
    """
    low = _small_step(values)
    if low == 0.0:
        return 0.0
    new = np.flatnonzero(np.diff(values)) + 1
    apart, steps = np.diff(stamp[new]), np.abs(np.diff(values)[new - 1])[1:]
    tick = float(np.median(np.diff(stamp)))
    within = (1.0 + EVEN) * tick  # what comes evenly is published at one of two ticks
    usual = float(np.median(apart[steps > THREEFOLD * low]))
    near = np.abs(apart - usual) <= within
    if np.mean(near) <= PART:
        return 0.0
    usual = float(np.mean(apart[near]))
    whole = usual * np.maximum(np.rint(apart / usual), 1.0)
    clocked = float(np.mean(np.abs(apart - whole) <= within)) >= NEARLY
    return usual if clocked and usual > CLEARLY * tick else 0.0


def _small_step(values: Array) -> float:
    """How far a joint goes from one of its readings (n,) to the next where that is little; 0 where all steps
    are alike, which tells nothing of a clock.
    """
    steps = np.abs(np.diff(values[np.flatnonzero(np.diff(values, prepend=np.nan))]))[1:]
    if len(steps) < FEWEST - 1:
        return 0.0
    low, high = np.quantile(steps, (0.1, 0.9))
    return float(low) if high > THREEFOLD * low else 0.0


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

    All joints that tell have to be held; one that goes from count to count at most tells nothing. Where they
    are read together, they stay in one row; where they are read in turn, the others are interpolated to the
    times of the joint with most readings. While nothing changes one sample is kept every other reading, since
    standing still is a fact as well.
    """
    stamp, telling = _telling(series)
    times = [holding(stamp, column) for column in telling]
    if not times or min(times) == 0.0:
        return series, 0.0
    usual, tick = float(np.median(times)), float(np.median(np.diff(stamp)))
    if in_turn(series, usual):
        return _at_one_time(series, usual, tick), usual
    new = series.rows(_kept(series.stamp, series.position, 2.0 * usual))
    return replace(new, stamp=asked(new.stamp, usual, tick)), usual


def _telling(series: JointSeries) -> tuple[Array, list[Array]]:
    """Stamps (n,) at which all that lives is known, and readings (n,) of each joint that tells of a clock."""
    read = series.position[:, np.isfinite(series.position).any(axis=0)]  # a dead sensor tells nothing
    known = np.isfinite(read).all(axis=1)
    stamp, position = series.stamp[known], read[known]
    return stamp, [column for column in position.T if _small_step(column) > 0.0] if len(stamp) else []


def in_turn(series: JointSeries, usual: float) -> bool:
    """Whether some joint has its new readings, about every ``usual`` s, at other times than another one."""
    stamp, telling = _telling(series)
    new = sorted((stamp[1:][np.diff(column) != 0.0] for column in telling), key=len)
    for others in new[:-1]:
        after = np.clip(np.searchsorted(new[-1], others), 1, len(new[-1]) - 1)
        apart = np.minimum(np.abs(others - new[-1][after - 1]), np.abs(others - new[-1][after]))
        apart = apart[apart < usual / 2.0]  # the other one may have stood elsewhere
        if len(apart) >= FEWEST and np.mean(apart < np.median(np.diff(stamp)) / 2.0) < HALF:
            return True
    return False


def _at_one_time(series: JointSeries, usual: float, tick: float) -> JointSeries:
    """The new readings of the joint that has most of them, and those of the others between theirs."""
    parts = [_when_read(series.select((joint,)), usual, tick) for joint in series.joints]
    stamp = max((part.stamp for part in parts), key=len)
    position, velocity, effort = (
        None
        if getattr(series, name) is None
        else _between([(p.stamp, getattr(p, name)) for p in parts], stamp)
        for name in ("position", "velocity", "effort")
    )
    assert position is not None
    return JointSeries(stamp, series.joints, position, velocity, effort)


def _when_read(one: JointSeries, usual: float, tick: float) -> JointSeries:
    """The new readings of a joint at the times at which they were read."""
    stamp, new = one.stamp.copy(), _kept(one.stamp, one.position, np.inf)
    if new.sum() > FEWEST:
        stamp[new] = asked(stamp[new], usual, tick)
    rows = np.flatnonzero(_kept(one.stamp, one.position, 2.0 * usual))
    rows = rows[
        np.append(stamp[rows[:-1]] < stamp[rows[1:]], True)
    ]  # a rest goes on until the next one is read
    return replace(one.rows(rows), stamp=stamp[rows])


def _between(parts: list[tuple[Array, Array]], stamp: Array) -> Array:
    """(n, joints) at common stamps (n,), of the stamps (k,) and readings (k, 1) of each joint."""
    return np.column_stack([at_stamps(stamp, own, column[:, 0], held=False) for own, column in parts])


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
