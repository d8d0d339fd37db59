"""Two clocks that do not run alike: the joints' lag behind the gearbox grows or shrinks with time.

What physics does to a joint depends on that joint; what a clock does to a topic comes on all joints alike.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import chdtri

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.data.sensing.physics import (
    CLOCKED,
    Motion,
    beside_physics,
    fitted,
    some_motion,
    wider_plays,
)
from trunk_ros.levels import CERTAIN, CHANCE, HALF, MOST, NOTABLE, ROUGHLY, SURE
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.resample import SAME

LARGEST = 5e-3  # s/s: no clock is worse


@dataclass(frozen=True)
class Skew:
    """By how much the joints' stamps run ahead, s per s, with std."""

    rate: float
    std: float


def one_clock(first: Array, second: Array) -> bool:
    """Whether stamps (n,) and (m,) are of one clock: most of the second are among the first."""
    place = np.clip(np.searchsorted(first, second), 1, len(first) - 1)
    apart = np.minimum(np.abs(first[place] - second), np.abs(first[place - 1] - second))
    return bool(np.mean(apart < SAME) > HALF)


def skew(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Skew | None:
    """The skew of the joints' clock against the gearbox's, of series with the same joints; None where none is
    certain.

    Certain is a lag that grows evenly with time and on several joints alike, beyond what load, posture,
    creep, friction (and its wear), coupling and inertia do to a joint.
    """
    motion = _between_clocks(gearbox, shown, arm)
    looks = () if motion is None else _looks(motion)
    told = (look for look in looks if look.certain and (look.shared or len(arm.joints) == 1))
    return next((look.skew for look in told), None)


def unseen_skew(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> float:
    """How far from none [s/s] a skew may be that is not certain; 0 where one clock made all stamps, or
    nothing tells how far two may differ.
    """
    motion = _between_clocks(gearbox, shown, arm)
    if motion is None:
        return 0.0
    look = _growth(motion, 3)[0]
    rate = look.skew.rate if look.shared else 0.0  # what one joint says alone is its own
    return float(min(np.hypot(rate, look.skew.std), LARGEST))


def _between_clocks(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Motion | None:
    """Some of the motion, where two clocks may tell it."""
    if min(len(gearbox.stamp), len(shown.stamp)) < CLOCKED or one_clock(gearbox.stamp, shown.stamp):
        return None
    return some_motion(gearbox, shown, arm)


def without_skew(shown: JointSeries, found: Skew) -> JointSeries:
    """The series with stamps of the gearbox's clock, which agreed with its own at 0 s."""
    return replace(shown, stamp=shown.stamp / (1.0 + found.rate))


@dataclass(frozen=True)
class _Look:
    """What joints say, (joints,) with std, and ``over`` what (joints, k) it lies on a line if clocks make it:
    the last slope is their skew.
    """

    said: Array
    std: Array
    over: Array

    @cached_property
    def line(self) -> tuple[Array, Array]:
        """(k,) slopes and their covariance (k, k)."""
        over = self.over / self.std[:, None]
        covariance = np.linalg.pinv(over.T @ over).astype(float)
        return covariance @ (over.T @ (self.said / self.std)), covariance

    @property
    def spread(self) -> float:
        """The std of the skew by those of the joints."""
        return float(np.sqrt(self.line[1][-1, -1]))

    def off(self, alike: float = 0.0) -> Array:
        """(able,) squares of how far joints that tell something are off the line, in std and in a share of it
        by which they may differ.
        """
        there = self.over @ self.line[0]
        off = (self.said - there) ** 2 / (self.std**2 + (alike * there) ** 2)
        return np.asarray(off[NOTABLE * self.std < np.abs(there)])

    @cached_property
    def skew(self) -> Skew:
        """What all say, with a std that is larger where they differ."""
        differ = float(np.mean(self.off())) if len(self.off()) else 1.0
        return Skew(float(self.line[0][-1]), self.spread * max(differ, 1.0) ** 0.5)

    @property
    def certain(self) -> bool:
        """Whether a clock may run so and joints differ from it by chance, or as rough looks do."""
        off = self.off(ROUGHLY)
        alike = off.sum() <= chdtri(max(len(off) - len(self.line[0]), 1), CHANCE)
        return bool(alike and CERTAIN * self.skew.std < abs(self.skew.rate) < LARGEST)

    @property
    def shared(self) -> bool:
        """Whether no joint says it alone: without any of them the others are sure."""
        alone = np.eye(len(self.std), dtype=bool)
        others = (replace(self, std=np.where(one, np.inf, self.std)) for one in alone)
        sure = (SURE * other.spread < abs(self.skew.rate) for other in others)
        return len(self.std) > len(self.line[0]) and all(sure)


def _looks(motion: Motion) -> Iterator[_Look]:
    """At how evenly lags grow, where they show no other way; and at the lags of joints that move one after
    the other, each of which sees little growth.
    """
    evenly, *others = _growth(motion, 3)
    least = HALF * abs(evenly.skew.rate)
    if all(abs(way.skew.rate) < max(SURE * way.skew.std, least) for way in others):
        yield from _growth(motion, 1)
    power = motion.speed[:, motion.moving] ** 2
    when = (motion.stamp - motion.stamp[0]) @ power / power.sum(axis=0)
    if np.ptp(when) > (1.0 - MOST) * np.ptp(motion.stamp):
        (lags,) = _growth(motion, 0)
        yield replace(lags, over=np.column_stack([np.ones_like(when), when]))


def _growth(motion: Motion, ways: int) -> list[_Look]:
    """How the lag of each joint grows with time, s/s, evenly and in so many ways at all; of none the lag, s.
    A joint that is late by itself, or the friction of which wears, is not late by a clock that runs evenly.
    """
    length = float(np.ptp(motion.stamp)) / 2
    x = (motion.stamp - motion.stamp[0]) / length - 1.0
    growths = [length * x, length * (x**2 - 1 / 3), length * (x**3 - 0.6 * x)][:ways]
    said = []
    for joint in motion.moving:
        late = -motion.speed[:, joint]
        besides = late, *wider_plays(motion, joint, wear=bool(ways))
        features = beside_physics(motion, joint, *(late * way for way in growths), *besides, wear=bool(ways))
        said.append([each[: max(ways, 1)] for each in fitted(features, motion.off[:, joint])])
    over = np.ones((len(said), 1))
    return [_Look(value, std, over) for value, std in np.array(said).transpose(2, 1, 0)]
