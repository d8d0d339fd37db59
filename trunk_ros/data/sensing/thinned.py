"""Setpoints of which a logger kept some: between two of them the servo got others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import uniform_filter1d

from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.align import SETTLING
from trunk_ros.guards import TINY
from trunk_ros.levels import CLEARLY, ENOUGH, HALF, PART, SURE, TENFOLD
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.encoder import EVEN
from trunk_ros.recording.signal.fill import fill, finer
from trunk_ros.recording.signal.resample import SAME
from trunk_ros.servo_course import servo_course

KIND = "thinned"
TIMES = (2, 3, 4, 5, 8, 10, 20)  # as many setpoints as were kept


@dataclass(frozen=True)
class Thinned:
    """How many setpoints there were for each that was kept, and all of them as they have to have been."""

    times: int
    setpoints: JointSeries


def thinned(
    setpoints: JointSeries, gearbox: JointSeries, model: ArmModel, guide: JointSeries | None = None
) -> Thinned | None:
    """All setpoints where the recorded ones would have made stairs that the gearbox does not show.

    The series have the same joints. guide: the reference, on the gearbox's side, shows what lies between.
    """
    period = _period(setpoints.stamp)
    if period == 0.0 or len(gearbox.stamp) < ENOUGH or 2.0 * _usual(gearbox.stamp) > period:
        return None
    stamp = setpoints.stamp
    course = servo_course(setpoints, gearbox.stamp, model)
    off = _off_course(gearbox, course)
    kept, chance = _stairs(off, course, gearbox, stamp)
    if kept <= SURE * chance:
        return None
    close = servo_course(setpoints, finer(gearbox.stamp, round(TENFOLD)), model)
    if _stairs(_off_course(close, course), course, gearbox, stamp)[0] >= HALF * kept:
        return None  # the steps of the servo's own course make them
    tried = [
        (*_stairs(_off_course(gearbox, there), there, gearbox, stamp), times, each)
        for times, each in _fuller(setpoints, guide)
        for there in [servo_course(each, gearbox.stamp, model)]
    ]
    least = min(stairs for stairs, *_ in tried)
    if least >= PART * kept:  # a servo that is slower shows a part of them
        return None
    shown = round(period / _usual(gearbox.stamp))  # drives are mostly told as often as they answer
    as_few = [
        (left > CLEARLY * max(least, by_chance), times != shown, left) for left, by_chance, times, _ in tried
    ]
    _, _, times, whole = tried[as_few.index(min(as_few))]
    return Thinned(times, whole)


def how_far_off(recordings: Sequence[Recording], joints: tuple[str, ...]) -> Array:
    """(joints,) rad rms by which setpoints that were filled in are off at most: as far as those that were
    kept are from a course through every second of them, and less by as much as that is nearer than one
    through every fourth. 0 where none were, or where a reference told what lies between.
    """
    off = [_off(recording, joints) for recording in recordings]
    return np.max(off, axis=0) if off else np.zeros(len(joints))


def _off(recording: Recording, joints: tuple[str, ...]) -> Array:
    times = next((round(o.value) for o in recording.observed if o.kind == KIND and o.corrected), 1)
    if times == 1 or "reference" in recording.series:
        return np.zeros(len(joints))
    setpoints = recording.series["setpoints"].select(joints)
    stamp, kept = setpoints.stamp[::times], setpoints.position[::times]
    second, fourth = (_missed(stamp, kept, every) for every in (2, 4))
    return np.asarray(second**2 / np.maximum(np.maximum(fourth, second), TINY))


def _missed(stamp: Array, known: Array, every: int) -> Array:
    """(joints,) rms by which setpoints (n, joints) are off a course through some of them."""
    last = (len(stamp) - 1) // every * every + 1
    there = PchipInterpolator(stamp[:last:every], known[:last:every])(stamp[:last])
    between = np.arange(last) % every > 0
    return np.asarray(np.sqrt(np.mean((there - known[:last])[between] ** 2, axis=0)))


def _usual(stamp: Array) -> float:
    return float(np.median(np.diff(stamp)))


def _period(stamp: Array) -> float:
    """Time between setpoints [s], 0 where they come unevenly or are few."""
    if len(stamp) < ENOUGH:
        return 0.0
    usual = _usual(stamp)
    return usual if float(np.mean(np.abs(np.diff(stamp) - usual) < EVEN * usual)) > 1.0 - EVEN else 0.0


def _fuller(setpoints: JointSeries, guide: JointSeries | None) -> list[tuple[int, JointSeries]]:
    """The setpoints with more and more between them; where a guide tells how many there were, with those."""
    counts: tuple[int, ...] = TIMES
    if guide is not None and len(guide.stamp) >= ENOUGH:
        there = round(_usual(setpoints.stamp) / _usual(guide.stamp))
        counts = (there,) if there > 1 else TIMES
    return [(times, _filled(setpoints, times, guide)) for times in counts]


def _filled(setpoints: JointSeries, times: int, guide: JointSeries | None) -> JointSeries:
    """As many setpoints between the kept ones, evenly; they move as the guide does, or smoothly."""
    first = setpoints.stamp
    stamp = finer(first, times)
    known = fill(setpoints.position)
    if guide is None:
        position = PchipInterpolator(first, known)(stamp)
    else:
        position = _led(stamp, guide) + _between(stamp, first, known - _led(first, guide))
    return JointSeries(stamp, setpoints.joints, np.asarray(position))


def _led(stamp: Array, guide: JointSeries) -> Array:
    return _between(stamp, guide.stamp, fill(guide.position))


def _between(stamp: Array, first: Array, known: Array) -> Array:
    return np.column_stack([np.interp(stamp, first, column) for column in known.T])


def _off_course(shown: JointSeries, course: JointSeries) -> Array:
    """(n, joints) rad by which a course (n,) is off what a series shows at the same moments."""
    at = np.searchsorted(shown.stamp, course.stamp)
    return np.asarray(course.position - fill(shown.position)[at])


def _stairs(off: Array, course: JointSeries, gearbox: JointSeries, kept: Array) -> tuple[float, float]:
    """Rms [rad] of stairs in how far the course of the servos (n,) is ``off`` (n, joints), which is what goes
    with speed and with the time since the last setpoint that was ``kept`` (k,) s; and what chance makes of
    it. A servo that is another one is off at all of these times alike.
    """
    period = _usual(kept)
    size = max(round(period / _usual(gearbox.stamp)), 2)
    fast = off - uniform_filter1d(off, size, axis=0)
    speed = np.gradient(course.position, course.stamp, axis=0)
    since = course.stamp - kept[np.maximum(np.searchsorted(kept, course.stamp + SAME, side="right") - 1, 0)]
    step = np.clip(np.rint(since / period * size), 0, size - 1).astype(int)
    settled = course.stamp > course.stamp[0] + SETTLING
    power, along = (
        np.bincount(step[settled], np.sum(x[settled], axis=1), size) for x in (speed**2, speed * fast)
    )
    heights = along / np.maximum(power, TINY)
    heights -= power @ heights / max(power.sum(), TINY)
    rows = np.count_nonzero(settled)
    return (
        float(np.sqrt(power @ heights**2 / off[settled].size)),
        float(np.sqrt(np.mean(fast[settled] ** 2) * size / (rows * off.shape[1]))),
    )
