"""Two clocks that do not run alike: the joints' lag behind the gearbox grows or shrinks with time.

What physics does to a joint depends on that joint; what a clock does to a topic comes on all joints alike.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.sensing.physics import CLOCKED, Motion, beside_physics, fitted, motion_of
from trunk_ros.diagnosis.levels import CERTAIN, CHANCE, CLEARLY, MOST, NEARLY, PART, ROUGHLY, ROWS, SURE
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.resample import SAME, SLOW

LARGEST = 5e-3  # s/s: no clock is worse
IN_TURN = 4  # joints that move one after the other, whose lags lie on a line over their times
WINDING = np.array([1 / 3, 4 / 45, 4 / 175])  # mean squares of the first three Legendre polynomials, as below


@dataclass(frozen=True)
class Skew:
    """By how much the joints' stamps run ahead, s per s, with std."""

    rate: float
    std: float


def one_clock(first: Array, second: Array) -> bool:
    """Whether stamps (n,) and (m,) are of one clock: most of the second are among the first."""
    place = np.clip(np.searchsorted(first, second), 1, len(first) - 1)
    apart = np.minimum(np.abs(first[place] - second), np.abs(first[place - 1] - second))
    return bool(np.mean(apart < SAME) > 0.5)


def skew(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Skew | None:
    """The skew of the joints' clock against the gearbox's, of series with the same joints; None where none is
    certain.

    Certain is a lag that all joints share and that grows evenly with time, beyond what load, posture, creep,
    friction (and its wear), coupling and inertia do to a joint. Where joints go at one speed each, wear and
    skew look alike on one of them; then three joints of different speeds have to say the same.
    """
    motion = _between_clocks(gearbox, shown, arm)
    return None if motion is None else _said(motion)


def unseen_skew(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> float:
    """Standard deviation [s/s] by which a skew is not known that is not certain; 0 where one clock made all
    stamps, or nothing tells how far two may differ.
    """
    motion = _between_clocks(gearbox, shown, arm)
    return min(_told(motion, True).skew.std, LARGEST) if motion is not None and motion.moving else 0.0


def _between_clocks(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Motion | None:
    """Some of the motion, where two clocks may tell it and it was sampled often enough."""
    if min(len(gearbox.stamp), len(shown.stamp)) < CLOCKED or one_clock(gearbox.stamp, shown.stamp):
        return None
    if float(np.median(np.diff(shown.stamp))) > SLOW / 2:
        return None
    shown = shown.rows(np.arange(len(shown.stamp)) % max(len(shown.stamp) // ROWS, 1) == 0)
    return motion_of(gearbox, shown, arm)


def without_skew(shown: JointSeries, found: Skew) -> JointSeries:
    """The series with stamps of the gearbox's clock, which agreed with its own at 0 s."""
    return replace(shown, stamp=shown.stamp / (1.0 + found.rate))


@dataclass(frozen=True)
class _Told:
    """What moving joints say: growth of their lag, evenly and in other ways, (joints, ways) s/s, with std.
    ``wear``: each may have friction that grows as well.
    """

    grown: Array
    spread: Array
    wear: bool

    @property
    def std(self) -> Array:
        """(joints,) of the even one."""
        return self.spread[:, 0]

    @property
    def together(self) -> Array:
        """(3,) s/s of all joints."""
        return np.asarray(self.std**-2.0 @ self.grown / np.sum(self.std**-2.0))

    @property
    def even(self) -> bool:
        """Whether nothing is seen of the other ways."""
        weight = self.spread[:, 1:] ** -2.0
        return bool((np.sum(weight * self.grown[:, 1:], axis=0) ** 2 < SURE**2 * weight.sum(axis=0)).all())

    @property
    def able(self) -> np.ndarray:
        """(joints,) that can tell."""
        return np.asarray(SURE * self.std < abs(self.together[0]))

    @property
    def off(self) -> Array:
        """(joints,) s/s from what all say."""
        return np.asarray(np.abs(self.grown[:, 0] - self.together[0]))

    @property
    def skew(self) -> Skew:
        """What all say, with a std that is larger where they differ."""
        differ = np.sqrt(np.mean((self.off / self.std)[self.able] ** 2)) if self.able.any() else 1.0
        return Skew(float(self.together[0]), self.alone * max(float(differ), 1.0))

    @property
    def alone(self) -> float:
        """The std of what all say by those of each."""
        return float(np.sum(self.std**-2.0) ** -0.5)

    @property
    def agree(self) -> bool:
        """Whether those that can tell say the same, and it is a clock's way to grow."""
        alike = (ROUGHLY if self.wear else PART) * abs(self.together[0])
        near = (self.off < np.maximum(SURE * self.std, alike))[self.able]
        share = self.together**2 * WINDING
        sure = CERTAIN * self.skew.std < abs(self.together[0]) < LARGEST
        return bool(near.all() and sure and share[0] > NEARLY * share.sum())


def _said(motion: Motion) -> Skew | None:
    if not motion.moving:
        return None
    whole, bare = _told(motion, True), _told(motion, False)
    if whole.agree and whole.able.sum() >= min(2, len(motion.joints)):
        return whole.skew
    both = SURE * np.hypot(whole.skew.std, bare.skew.std) + ROUGHLY * abs(bare.skew.rate)
    if not bare.agree or bare.able.sum() < 3 or abs(whole.skew.rate - bare.skew.rate) > both:
        return _from_joint_to_joint(motion) or _rarely(motion, whole)
    speeds = np.sqrt(np.mean(motion.speed[:, motion.moving] ** 2, axis=0))[bare.able]
    # joints of one speed are late alike for other reasons
    return bare.skew if speeds.max() > CLEARLY * speeds.min() else None


def _rarely(motion: Motion, whole: _Told) -> Skew | None:
    """The same of joints that move too rarely to tell in which way their lag grows: evenly, if nothing shows
    of another way, as much on each of them as on all.
    """
    if len(motion.moving) < IN_TURN or not whole.even:
        return None
    evenly = _told(motion, True, 1)
    rate, spread, off = float(evenly.together[0]), evenly.alone, evenly.off / evenly.std
    alike = float(off @ off) < chdtri(len(off) - 1, CHANCE)
    return Skew(rate, spread) if alike and CERTAIN * spread < abs(rate) < LARGEST else None


def _from_joint_to_joint(motion: Motion) -> Skew | None:
    """The same of joints that move one after the other, each of which sees little of a skew: the lags of all
    of them, each with its own std, lie on a line over the times at which they move.
    """
    if len(motion.moving) < IN_TURN:
        return None
    power = motion.speed[:, motion.moving] ** 2
    when = (motion.stamp - motion.stamp[0]) @ power / power.sum(axis=0)
    lag, std = np.array([_lag(motion, joint) for joint in motion.moving]).T
    line = np.column_stack([np.ones_like(when), when]) / std[:, None]
    covariance = np.linalg.pinv(line.T @ line)
    found = covariance @ (line.T @ (lag / std))
    rate, spread, off = float(found[1]), float(np.sqrt(covariance[1, 1])), lag / std - line @ found
    on_line = float(off @ off) < chdtri(len(lag) - 2, CHANCE)
    apart = np.ptp(when) > (1.0 - MOST) * np.ptp(motion.stamp)
    return Skew(rate, spread) if on_line and apart and CERTAIN * spread < abs(rate) < LARGEST else None


def _lag(motion: Motion, joint: int) -> tuple[float, float]:
    """s that a joint is late, and the std."""
    features = beside_physics(motion, joint, -motion.speed[:, joint], wear=False)
    values, spread = fitted(features, motion.off[:, joint])
    return float(values[0]), float(spread[0])


def _told(motion: Motion, wear: bool, ways: int = 3) -> _Told:
    each = [_of_joint(motion, joint, wear, ways) for joint in motion.moving]
    return _Told(np.array([one[0] for one in each]), np.array([one[1] for one in each]), wear)


def _of_joint(motion: Motion, joint: int, wear: bool, many: int) -> tuple[Array, Array]:
    """Lag of a joint that grows with time, s/s, evenly and in so many ways at all, (ways,), and its std; the
    std is from blocks of samples, so that what is smooth counts once.
    """
    late, length = -motion.speed[:, joint], float(np.ptp(motion.stamp)) / 2
    x = (motion.stamp - motion.stamp[0]) / length - 1.0
    ways = np.column_stack([x, x**2 - 1 / 3, x**3 - 0.6 * x])[:, :many] * length
    features = beside_physics(motion, joint, *(ways * late[:, None]).T, late, wear=wear)
    values, spread = fitted(features, motion.off[:, joint])
    return values[:many], spread[:many]
