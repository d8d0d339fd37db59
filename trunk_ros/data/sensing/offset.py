"""Clocks that are off by a constant: from the beginning on, or from a moment in mid-run on, as a time server
sets them.

Physics makes a joint late, never early, and leaves the stamps of its readings as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.data.noise import rms
from trunk_ros.data.sensing.physics import (
    CLOCKED,
    CREEPS,
    Motion,
    beside_physics,
    fitted,
    lowpassed,
    scaled,
    some_motion,
    while_driven,
)
from trunk_ros.guards import BLIND, TINY
from trunk_ros.levels import CERTAIN, FEWEST, HALF, MOST, NEARLY, PART, ROUGH, SEVERAL, SURE, TURNS
from trunk_ros.recording.recording import JointSeries

QUICK = CREEPS[0] ** 2 / CREEPS[1]  # s: a wire that creeps back so soon leads for a while


@dataclass(frozen=True)
class Offset:
    """By how much stamps run ahead, s with std; ``since``: s from which on, None from the beginning on."""

    size: float
    std: float
    since: float | None = None

    def off(self, series: JointSeries) -> JointSeries:
        """The series with stamps without it; samples that then come before earlier ones are left out."""
        late = series.stamp >= (-np.inf if self.since is None else self.since)
        return series.restamped(series.stamp - self.size * late)


def early(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Offset | None:
    """By how much the joints' stamps run behind (a negative size): they show motion before the gearbox makes
    it, all moving joints by the same time, but for some that physics makes late. Series with the same joints.
    What leads by as long as motion itself takes to turn goes by its speed, as the force of a damper does.
    """
    size, std = 0.0, 0.0
    for _ in range(TURNS):  # what is left of a large one shows when most of it is gone
        motion = some_motion(gearbox, while_driven(gearbox, Offset(size, std).off(shown)), arm)
        found = None if motion is None else _earlier(motion)
        if motion is None or found is None:
            break
        size, std = size + found.size, found.std
        if -size > HALF * _turns_in(motion):
            return None
    return Offset(size, std) if size < 0.0 else None


def _earlier(motion: Motion) -> Offset | None:
    lags = [_lag(motion, joint) for joint in motion.moving]
    found = _together(lags, max(min(SEVERAL, len(motion.joints)), MOST * len(lags)), True)
    return found if found is not None and found.size < 0.0 else None


def _turns_in(motion: Motion) -> float:
    """s in which the quickest joint goes as far as it is from its middle: a radian of a swing."""
    return min(float(np.std(motion.asked[:, j]) / rms(motion.speed[:, j])) for j in motion.moving)


def step(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> tuple[int, Offset] | None:
    """Which of the two topics, 0 or 1, has a clock that was set in mid-run, and by how much: the lag of all
    joints jumps at one moment, and so do the stamps of that topic, by as much. Readings that get older from a
    moment on come as evenly as before.
    """
    motion = some_motion(gearbox, while_driven(gearbox, shown), arm)
    if motion is None:
        return None
    gain = _gains(motion)
    gain[:CLOCKED] = gain[len(gain) - CLOCKED :] = 0.0  # of fewer samples nothing is told
    if not gain.any():
        return None
    near, at = motion.stamp[gain > NEARLY * gain.max()], float(motion.stamp[np.argmax(gain)])
    found = _together([_step_of(motion, joint, at) for joint in motion.moving], 1)
    if found is None:
        return None
    for k, (series, way) in enumerate(((gearbox, -1.0), (shown, 1.0))):
        told = in_stamps(series.stamp, Offset(way * found.size, found.std), near)
        if told is not None:
            return k, told
    return None


def _lag(motion: Motion, joint: int) -> tuple[float, float]:
    """s that a joint is late, and the std; infinite where it seems early and physics may be why: a dead band
    that fades with speed, which holds the joint back at rest by as much as it no longer does in motion, or a
    wire that creeps back quickly.
    """
    speed, load = motion.speed[:, joint], float(np.mean(np.abs(motion.load[:, joint])))
    features, off = beside_physics(motion, joint, -speed, wear=False), motion.off[:, joint]
    values, spread = fitted(features, off)
    late, std = float(values[0]), float(spread[0])
    if late > 0.0:
        return late, std
    band = -float(values[1:4] @ [1.0, load, 1.0])  # of friction: always, by load, at low speed
    fades = -late * rms(speed) < band - float(motion.arm.dead_band[joint])
    creep = lowpassed(motion.stamp, motion.asked[:, joint], QUICK)
    beside, unsure = (each[0] for each in fitted(np.column_stack([features, creep]), off))
    creeps = abs(beside - late) > SURE * np.hypot(std, unsure) + PART * abs(late)
    return late, np.inf if fades or creeps else std


def _together(told: list[tuple[float, float]], fewest: float, later: bool = False) -> Offset | None:
    """What the moving joints say, s and std of each, where they agree and at least ``fewest`` of them are
    sure; ``later``: but for the latest.
    """
    size, std = np.array(told).T
    while len(size) >= fewest:
        weight = std**-2.0
        if not weight.any():
            return None
        mean = float(weight @ size / weight.sum())
        able, off = SURE * std < abs(mean), np.abs(size - mean)
        if np.all((off < np.maximum(SURE * std, PART * abs(mean)))[able]):
            differ = np.sqrt(np.mean((off / std)[able] ** 2)) if able.any() else 1.0
            spread = float(weight.sum() ** -0.5 * max(differ, 1.0))
            sure = able.sum() >= fewest and CERTAIN * spread < abs(mean)
            return Offset(mean, spread) if sure else None
        if not later:
            return None
        size, std = np.delete(size, np.argmax(size)), np.delete(std, np.argmax(size))
    return None


def _lags(motion: Motion, joint: int, *own: Array) -> Array:
    """(n, features): such as are (n,), and what physics and clocks do that are not set."""
    late = -motion.speed[:, joint]
    return beside_physics(motion, joint, *own, late, late * motion.time)


def _step_of(motion: Motion, joint: int, since: float) -> tuple[float, float]:
    """s by which a joint is later from a moment on, and the std."""
    late = -motion.speed[:, joint] * (motion.stamp >= since)
    values, spread = fitted(_lags(motion, joint, late), motion.off[:, joint])
    return float(values[0]), float(spread[0])


def _gains(motion: Motion) -> Array:
    """(n,) what one jump of the lag of all joints at each sample explains, in units of what is left."""
    along, square = np.zeros(len(motion.stamp)), np.zeros(len(motion.stamp))
    for joint in motion.moving:
        late, off = -motion.speed[:, joint], motion.off[:, joint]
        u, size, _ = np.linalg.svd(scaled(_lags(motion, joint))[0], full_matrices=False)
        u = u[:, size**2 > BLIND * size[0] ** 2]
        rest = off - u @ (u.T @ off)
        power = max(float(rest @ rest), TINY)
        along += _from_here(late * rest) / power
        square += (_from_here(late**2) - np.sum(_from_here(u * late[:, None]) ** 2, axis=1)) / power
    seen = square > BLIND * square.max()
    return np.where(seen, along**2 / np.where(seen, square, 1.0), 0.0)


def _from_here(each: Array) -> Array:
    """Sums over axis 0 from each row to the last."""
    return np.asarray(np.cumsum(each[::-1], axis=0)[::-1])


def in_stamps(stamp: Array, found: Offset, near: Array) -> Offset | None:
    """The offset as the stamps (n,) have it, where they jump by it, beside samples that were lost, between
    the first and the last of the times near (k,).
    """
    if len(stamp) < CLOCKED:
        return None
    between = np.diff(stamp)
    period = float(np.median(between))
    even = stamp - period * np.arange(len(stamp))
    jitter = float(np.median(np.abs(np.diff(between)))) / 6**0.5
    at = np.arange(FEWEST, len(stamp) - FEWEST)
    at = at[(stamp[at] >= near[0] - period) & (stamp[at] <= near[-1] + period)]
    if not len(at):
        return None
    middle = np.median(np.lib.stride_tricks.sliding_window_view(even, FEWEST), axis=1)
    jump = middle[at] - middle[at - FEWEST]
    known = max(jitter / FEWEST**0.5, ROUGH * period)
    beside = SURE * np.hypot(found.std, known) + PART * abs(found.size)
    if abs(found.size - period * np.rint(found.size / period)) > beside:  # no samples that are lost do that
        jump -= period * np.maximum(np.rint((jump - found.size) / period), 0.0)
    there = (np.abs(jump - found.size) < beside) & (np.abs(jump) > beside)
    if not there.any():
        return None
    k = at[there][np.argmax(np.abs(between[at[there] - 1] - period))]
    return Offset(float(jump[at == k][0]), known, float(stamp[k]))
