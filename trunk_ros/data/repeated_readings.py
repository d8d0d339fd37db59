"""Readings of a sensor that is slower than its topic: each is repeated until the next one comes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.merged_readings import between_messages
from trunk_ros.guards import TINY
from trunk_ros.levels import CLEARLY, ENOUGH, FEWEST, HALF, NEARLY, OUTLIERS, PART, THREEFOLD
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.encoder import EVEN
from trunk_ros.recording.signal.fill import hold
from trunk_ros.recording.signal.resample import SAME, resample
from trunk_ros.recording.staggered import at_stamps


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

    All joints that tell have to be held, by a clock or from message to message; one that goes from count to
    count at most tells nothing. Where they are read together, they stay in one row; where they are read in
    turn, the others are interpolated to the times of the joint with most readings. While nothing changes one
    sample is kept every other reading, since standing still is a fact as well.
    """
    stamp, telling = _telling(series)
    times = [holding(stamp, column) for column in telling]
    clocked = bool(times) and min(times) > 0.0
    usual = float(np.median(times)) if clocked else between_messages(stamp, telling)
    if usual == 0.0:
        return series, 0.0
    tick = float(np.median(np.diff(stamp)))
    if in_turn(series, usual):
        return _at_one_time(series, usual, tick), usual
    kept = _kept(series.stamp, series.position, 2.0 * usual)
    new = series.rows(kept | _ends_of_rests(series.stamp, series.position, usual))
    return replace(new, stamp=asked(new.stamp, usual, tick)), usual


def new_motor_readings(driven: JointSeries, shown: JointSeries | None) -> tuple[JointSeries, float]:
    """As ``new_readings``, of the motors that move the joints ``shown``: between two readings they go on.
    Where the joints are seen to go in the same steps, nothing is repeated: so the motors went.
    """
    new, usual = new_readings(driven)
    if usual and shown is not None and _in_steps(driven, new, shown, usual):
        return driven, 0.0
    return new, usual


def _in_steps(driven: JointSeries, new: JointSeries, shown: JointSeries, usual: float) -> bool:
    """Whether motors that hold each reading, for ``usual`` s, say clearly more of how the joints go from one
    of their readings to the next than motors that go on between ``new`` ones do, however late the joints are.
    """
    joints = shown.position[:, np.isfinite(shown.position).any(axis=0)]
    held, tick = hold(driven.position), float(np.median(np.diff(driven.stamp)))
    if len(shown.stamp) < ENOUGH or not joints.size:
        return False
    steps, smooth = [], []
    for late in np.arange(0.0, usual + tick, tick):
        at = shown.stamp - late
        last = np.clip(np.searchsorted(driven.stamp, at + SAME, side="right") - 1, 0, None)
        steps.append(_unsaid(held[last], joints))
        smooth.append(_unsaid(resample(new, at)[0], joints))
    return CLEARLY * min(steps) < min(smooth)


def _unsaid(motors: Array, joints: Array) -> float:
    """What steps of the motors (n, motors) leave of those of the joints (n, joints), squared, in the
    geometric mean over these.
    """
    by, of = np.diff(motors, axis=0), np.diff(joints, axis=0)
    known = np.isfinite(of).all(axis=1)
    left = of[known] - by[known] @ np.linalg.lstsq(by[known], of[known])[0]
    return float(np.exp(np.mean(np.log(np.mean(left**2, axis=0) + TINY))))


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
    out = _is_new(position)
    last = stamp[0]
    for k in range(len(stamp)):
        out[k] |= stamp[k] - last >= longest
        last = stamp[k] if out[k] else last
    return out


def _ends_of_rests(stamp: Array, position: Array, usual: float) -> np.ndarray:
    """(n,) the first and the last of equal readings, made every ``usual`` [s]: a rest begins and ends there,
    and not where it was kept first and last.
    """
    new, out = stamp[_is_new(position)], np.zeros(len(stamp), dtype=bool)
    first, last = new[:-1] + usual, new[1:] - usual
    rests = last > first - SAME
    out[np.searchsorted(stamp, first[rests] - SAME)] = True
    out[np.searchsorted(stamp, last[rests] + SAME) - 1] = True
    return out


def _is_new(position: Array) -> np.ndarray:
    """(n,) where a joint reads otherwise than before."""
    changed = (position[1:] != position[:-1]) & np.isfinite(position[1:])
    return np.append(True, np.any(changed, axis=1))


def coarseness(values: Array, valid: np.ndarray) -> float:
    """Standard deviation that a coarse sensor's steps add to its readings (n,); 0 where it is not coarse."""
    seen = values[valid]
    steps = np.abs(np.diff(seen))
    steps = steps[steps > 0.0]
    if len(steps) < FEWEST or len(np.unique(seen)) > PART * len(seen):
        return 0.0
    return float(np.median(steps) / np.sqrt(12.0))
