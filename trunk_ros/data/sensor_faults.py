"""Readings that say nothing of the joint: a sensor that stuck or died, and single ones that are far off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter, median_filter

from trunk_ros.compiled import Array
from trunk_ros.data.repeated_readings import new_readings
from trunk_ros.guards import ROUNDS
from trunk_ros.levels import (
    CERTAIN,
    CLEARLY,
    ENOUGH,
    FEWEST,
    HALF,
    PART,
    ROUGH,
    ROWS,
    SLIGHT,
    TENFOLD,
)
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.signal.encoder import EXACT, MEDIAN_TO_STD, count, noises
from trunk_ros.recording.signal.gaps import in_gaps, runs, usual
from trunk_ros.recording.topics import COMPARED, TOPICS
from trunk_ros.words import many

BESIDE = 3  # readings on either side of one that is far off
STUCK = 5  # equal readings in a row, of a sensor whose readings hardly ever repeat
WILD, USUALLY = 100.0, 0.8  # times as far as this share of the steps goes that a wild reading is off
FEW = SLIGHT  # of the readings: more of them are how the sensor is
AROUND = ENOUGH + 1  # readings whose scatter counts: a burst of noise is no row of single readings


def without_faults(recording: Recording) -> Recording:
    """A recording without such joint readings (they become NaN), and a note on each joint that had some."""
    recording = without_wild(recording)
    series = recording.series.get("joint_states")
    if series is None or len(series.stamp) < 10 * STUCK:
        return recording
    position, notes = series.position.copy(), []
    repeats = bool(new_readings(series)[1])  # old readings, beside a motor that goes on
    moved = [
        None if repeats else what_moves(recording, joint, series.stamp, readings)
        for joint, readings in zip(series.joints, position.T, strict=True)
    ]
    beside = [None if m is None else r - m for m, r in zip(moved, position.T, strict=True)]
    noise = noises(series)
    noisy = noise > [count(readings) for readings in position.T]  # at rest no two would be equal
    noisy &= not _rest_alike(position, moved)
    told = [left if one else None for left, one in zip(beside, noisy, strict=True)]
    sticking = all_that_sticks(position, series.stamp, told)
    for j, joint in enumerate(series.joints):
        stuck = sticking[:, j]
        stuck |= dead(np.where(stuck, np.nan, position[:, j]), told[j], noise[j])
        off = strays(position[:, j], moved[j])
        position[stuck | off, j] = np.nan
        if stuck.any():
            begin = series.stamp[np.flatnonzero(stuck)[0]]
            notes.append(
                f"{joint}: its sensor sticks, first at {begin:.2f} s; {stuck.sum()} readings left out"
            )
        if off.any():
            notes.append(f"{joint}: {off.sum()} single readings far from those beside them left out")
    if not notes:
        return recording
    changed = {**recording.series, "joint_states": replace(series, position=position)}
    return replace(recording, series=changed, notes=(*recording.notes, *notes))


def without_wild(recording: Recording) -> Recording:
    """A recording without single readings of joints and gearboxes that no arm can have shown, and notes."""
    series, notes = dict(recording.series), []
    for key in COMPARED["wire"]:
        if key not in series or len(series[key].stamp) < FEWEST:
            continue
        kept: dict[str, Any] = {}
        for name in ("position", "velocity", "effort"):
            values = getattr(series[key], name)
            out = np.zeros((0, 0)) if values is None else np.column_stack([wild(v) for v in values.T])
            if out.any():
                kept[name] = np.where(out, np.nan, values)
                joints = [joint for joint, one in zip(series[key].joints, out.T, strict=True) if one.any()]
                notes.append(
                    f"{TOPICS[key]}: {many(out.sum(), 'wild value')} of {name} ({', '.join(joints)}) left out"
                )
        series[key] = replace(series[key], **kept)
    return replace(recording, series=series, notes=(*recording.notes, *notes)) if notes else recording


def wild(readings: Array) -> np.ndarray:
    """(n,) single readings that are off by far more than most steps (n,), while those beside them agree; the
    first and the last, which have them on one side alone, by more than any other step.
    """
    known = np.flatnonzero(np.isfinite(readings))
    out = np.zeros(len(readings), dtype=bool)
    step = np.abs(np.diff(readings[known]))
    if len(known) < FEWEST or not (step > 0.0).any():
        return out
    most = float(np.quantile(step[step > 0.0], USUALLY))
    if step.max() < WILD * most / 4:
        return out
    beside = np.pad(readings[known], 2, mode="reflect")
    before, after = beside[1:-3], beside[3:-1]
    usual_there = np.median([beside[:-4], before, after, beside[4:]], axis=0)
    usual_there[[0, -1]] = readings[known][[1, -2]]  # from the one beside it: a median would lag behind
    off = np.abs(readings[known] - usual_there)
    found = (off > WILD * most) & (np.abs(after - before) < off / 2)
    others = np.abs(np.diff(readings[known][1:-1][~found[1:-1]])).max(initial=0.0)
    found[[0, -1]] &= off[[0, -1]] > CLEARLY * others
    out[known[found]] = found.mean() < FEW
    return out


def all_that_sticks(
    position: Array, stamp: Array, beside: Sequence[Array | None] | None = None
) -> np.ndarray:
    """(n, joints) where a sensor sticks; by joint, what is left ``beside`` the motor. Where one does and all
    joints repeat their readings the message is an old one, also for joints that hardly moved meanwhile and do
    not leap; but not for those that may as well have stood, as their readings often repeat.
    """
    left = beside or [None] * position.shape[1]
    stuck = np.column_stack([sticks(r, stamp, one) for r, one in zip(position.T, left, strict=True)])
    same = np.diff(position, axis=0, prepend=np.nan) == 0.0
    read = np.isfinite(position).any(axis=0)
    old = same[:, read].all(axis=1) & stuck.any(axis=1)
    rarely = read & ((same & ~old[:, None]).mean(axis=0) <= FEW)
    return np.asarray(stuck | (old[:, None] & rarely))


def sticks(readings: Array, stamp: Array, left: Array | None = None) -> np.ndarray:
    """(n,) where a sensor repeats one reading for long and leaps when it goes on, at ``stamp`` (n,) s; in
    what is ``left`` beside the motor where its noise would not let it repeat itself at rest either.

    Where readings are missing in between the joint may have gone there.
    """
    out = np.zeros(len(readings), dtype=bool)
    step = np.abs(np.diff(readings))
    same = step == 0.0
    long = [(first, last) for first, last in runs(same) if last - first >= STUCK - 1]
    rest = same.sum() - sum(last - first for first, last in long)
    if not long or rest > FEW * len(same):
        return out
    together = np.diff(stamp) <= usual(stamp)
    leaps = step > leap(readings)
    if left is not None:
        leaps |= np.abs(np.diff(left)) > leap(left)
    for first, last in long:
        if last < len(step) and leaps[last] and together[last]:
            out[first + 1 : last + 1] = True
    return out


def dead(readings: Array, left: Array | None, noise: float) -> np.ndarray:
    """(n,) where a sensor shows one angle but for its ``noise``, while what is ``left`` (n,) beside the motor
    goes far beyond what is usual, and leaps back when the sensor goes on. What scatters by more than it does
    elsewhere is a joint that moves, or a burst of noise.

    A joint that is held fast and breaks loose leaps as well, but on its way out: here the motor moves on and
    comes back meanwhile, or the sensor had leapt to what it shows. One that leaves a stop goes as fast as its
    motor does, which is no leap. Of single readings none leaps.
    """
    out = np.zeros(len(readings), dtype=bool)
    if left is None or len(known := np.flatnonzero(np.isfinite(readings + left))) <= AROUND:
        return out
    shown, left = readings[known], left[known] - np.median(left[known])
    usual = TENFOLD * MEDIAN_TO_STD * float(np.median(np.abs(left[_moved(shown - left)])))
    wide = BESIDE | 1  # a window has a middle
    before, after = (median_filter(left, wide, origin=side * (wide // 2)) for side in (1, -1))
    leaps = np.maximum(leap(left), CLEARLY * maximum_filter(np.abs(np.diff(shown - left)), 2 * BESIDE + 1))
    ends = np.minimum(np.abs(np.diff(left)), np.abs(after[1:] - before[:-1])) > leaps
    ends &= np.abs(after[1:]) < usual
    far = np.maximum.accumulate(np.where(np.abs(left) > usual, np.arange(len(left)), -1))
    for last in AROUND + np.flatnonzero(ends[AROUND:] & (far[AROUND:-1] >= 0)):
        if float(np.std(shown[last + 1 - FEWEST : last + 1])) > CLEARLY * noise:
            continue
        first = _shown_since(shown[: last + 1])
        if last - first <= AROUND or np.ptp((shown - left)[first : last + 1]) < usual:
            continue
        beyond = np.abs(left[first : last + 1])
        came_back = (np.maximum.accumulate(beyond) - beyond).max() > usual
        leapt = first > 0 and abs(left[first] - left[first - 1]) > usual
        if came_back or leapt:
            out[known[first : last + 1]] = True
    return out


def _moved(by: Array) -> np.ndarray:
    """(n,) where what moves a joint ``by`` (n,) is not at rest."""
    step = np.abs(np.gradient(by))
    return np.asarray(step >= PART * float(step.max()))


def _shown_since(readings: Array) -> int:
    """The first from which on all of them (n,) scatter as the last ones do."""
    angle, scatter = (float(of(readings[-FEWEST:])) for of in (np.median, np.std))
    first, size = len(readings) - FEWEST, AROUND
    while first > 0:
        begin = max(first - size, 0)
        away = np.flatnonzero(np.abs(readings[begin:first] - angle) > CERTAIN * scatter)
        if len(away):
            return begin + int(away[-1]) + 1
        first, size = begin, 2 * size
    return 0


def strays(readings: Array, moved: Array | None = None) -> np.ndarray:
    """(n,) readings that are far off, one or two at a time, while those beside them agree.

    ``moved`` (n,) by a motor: they are off beside it, where a fast motion hides nothing, and it is not itself
    what goes off and comes back: in a short reversal the joint may stay within its dead band.
    """
    left = readings if moved is None else readings - moved
    out = np.zeros(len(left), dtype=bool)
    known = np.flatnonzero(np.isfinite(left))
    if len(known) <= 2 * BESIDE:
        return out
    left = left[known]
    off, apart = _off(left)
    scatter = MEDIAN_TO_STD * float(np.median(off))
    found = (off > max(TENFOLD * scatter, leap(left, 1.0 - 2.0 * FEW))) & (apart < off / 2)
    found &= off > TENFOLD * MEDIAN_TO_STD * median_filter(off, AROUND)
    if moved is not None:
        found &= maximum_filter(_off(moved[known])[0], 2 * BESIDE + 1) < off / 2  # the joint may be late
    out[known[BESIDE:-BESIDE]] = found & (scatter > 0.0) & (found.mean() < FEW)
    return out


def _off(readings: Array) -> tuple[Array, Array]:
    """How far readings (n,) are from the middle of those beside them, and how far these are apart before and
    after, but for the first and last few.
    """
    beside = np.lib.stride_tricks.sliding_window_view(readings, 2 * BESIDE + 1)
    before, after = np.median(beside[:, :BESIDE], axis=1), np.median(beside[:, BESIDE + 1 :], axis=1)
    off = np.abs(beside[:, BESIDE] - np.median(np.delete(beside, BESIDE, axis=1), axis=1))
    return off, np.abs(after - before)


def _rest_alike(position: Array, moved: Sequence[Array | None]) -> bool:
    """Whether readings (n, joints) repeat where motors stand, as a rule: what looks like noise is the steps
    of the motors' encoders that a simulation was driven with.
    """
    pairs = [(r, m) for r, m in zip(position.T, moved, strict=True) if m is not None]
    alike = [(np.diff(r) == 0.0)[np.diff(m) == 0.0] for r, m in pairs]
    return sum(map(len, alike)) >= FEWEST and float(np.concatenate(alike).mean()) > HALF


def what_moves(recording: Recording, joint: str, stamp: Array, readings: Array) -> Array | None:
    """What of readings (n,) at ``stamp`` the joint's own motor moves, None where that was not recorded: in
    what is left a single reading shows that a fast motion hides. NaN in gaps of the motor's readings.
    """
    gearbox = recording.series.get("gearbox_states")
    if gearbox is None or joint not in gearbox.joints:
        return None
    motor = gearbox.position[:, gearbox.joints.index(joint)]
    seen = np.isfinite(motor)
    if seen.sum() < FEWEST:
        return None
    there = np.interp(stamp, gearbox.stamp[seen], motor[seen])
    there[in_gaps(gearbox.select((joint,)), stamp)[:, 0]] = np.nan
    known = np.isfinite(readings + there)
    if known.sum() < FEWEST or np.ptp(there[known]) == 0.0:
        return None
    return np.asarray(_slope(there[known] - there[known].mean(), readings[known]) * there)


def _slope(x: Array, y: Array) -> float:
    """Of the line with the least absolute deviations: a sensor that was dead for a while does not tilt it."""
    some = slice(None, None, max(len(x) // ROWS, 1))
    x, y, weight = x[some], y[some], np.ones(len(x[some]))
    for _ in range(ROUNDS):
        slope, middle = np.polyfit(x, y, 1, w=weight)
        off = np.abs(y - middle - slope * x)
        weight = 1.0 / np.sqrt(np.maximum(off, ROUGH * np.max(off, initial=EXACT)))
    return float(slope)


def leap(readings: Array, usual: float = 0.99) -> float:
    """Further than a joint goes between two readings (n,) that differ, by what is ``usual`` of them: each
    single reading that is off makes two large steps.
    """
    step = np.abs(np.diff(readings))
    return CLEARLY * float(np.nanquantile(step[step > 0.0], usual)) if (step > 0.0).any() else np.inf
