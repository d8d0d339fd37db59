"""Two clocks that do not run alike: the joints' lag behind the gearbox grows or shrinks with time.

What physics does to a joint depends on that joint; what a clock does to a topic comes on all joints alike.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.sensing.physics import Motion, basis
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.resample import SAME, SLOW, resample

SURE = 8.0  # standard deviations
EVENLY = 0.8  # of what grows in any way
LARGEST = 5e-3  # s/s: no clock is worse
TELLS = 0.25  # of the skew: the std of a joint that says something
AGREES = 4.0  # standard deviations from what all joints say, or as much of the skew as below
ALIKE, ALIKER = 0.25, 0.1
DIFFER = 1.3  # times the speed of the slowest: joints of one speed are late alike for other reasons
FEWEST = 200  # samples
ROWS = 6000  # samples that are enough
BLOCK = 50  # of them may depend on each other
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
    if min(len(gearbox.stamp), len(shown.stamp)) < FEWEST or one_clock(gearbox.stamp, shown.stamp):
        return None
    if float(np.median(np.diff(shown.stamp))) > SLOW / 2:
        return None
    shown = shown.rows(np.arange(len(shown.stamp)) % max(len(shown.stamp) // ROWS, 1) == 0)
    phi, velocity = resample(gearbox, shown.stamp)
    motion = Motion(shown.stamp, phi * arm.ratio, velocity * arm.ratio, fill(shown.position), arm)
    return _said(motion, wear=True) or _said(motion, wear=False)


def without_skew(shown: JointSeries, found: Skew, begin: float = 0.0) -> JointSeries:
    """The series with stamps of the gearbox's clock, which agreed with its own at ``begin`` s."""
    return replace(shown, stamp=begin + (shown.stamp - begin) / (1.0 + found.rate))


def _said(motion: Motion, wear: bool) -> Skew | None:
    """What the joints say together; ``wear``: each may have friction that grows as well."""
    if not motion.moving:
        return None
    each = [_of_joint(motion, joint, wear) for joint in motion.moving]
    grown, std = np.array([one[0] for one in each]), np.array([one[1][0] for one in each])
    weight = std**-2.0 / np.sum(std**-2.0)
    together, spread = weight @ grown, float(np.sum(std**-2.0) ** -0.5)
    rate = float(together[0])
    able, off = std < TELLS * abs(rate), np.abs(grown[:, 0] - rate)
    near = off < np.maximum(AGREES * std, (ALIKE if wear else ALIKER) * abs(rate))
    if not able.any() or not near[able].all() or not _enough(motion, able, wear) or abs(rate) > LARGEST:
        return None
    spread *= max(float(np.sqrt(np.mean((off / std)[able] ** 2))), 1.0)
    share = together**2 * WINDING
    return Skew(rate, spread) if share[0] > EVENLY * share.sum() and abs(rate) > SURE * spread else None


def _enough(motion: Motion, able: np.ndarray, wear: bool) -> bool:
    """Whether those of the moving joints that are ``able`` to tell are enough."""
    if wear:
        return bool(able.sum() >= min(2, len(motion.joints)))
    speeds = np.sqrt(np.mean(motion.speed[:, motion.moving] ** 2, axis=0))[able]
    return bool(able.sum() >= 3 and np.ptp(np.log(speeds)) > np.log(DIFFER))


def _of_joint(motion: Motion, joint: int, wear: bool) -> tuple[Array, Array]:
    """Lag of a joint that grows with time, s/s, evenly and in two other ways, (3,), and its std; the std is
    from blocks of samples, so that what is smooth counts once.
    """
    late, length = -motion.speed[:, joint], float(np.ptp(motion.stamp)) / 2
    x = (motion.stamp - motion.stamp[0]) / length - 1.0
    ways = np.column_stack([x, x**2 - 1 / 3, x**3 - 0.6 * x]) * length
    features = np.column_stack([ways * late[:, None], late, basis(motion, joint, wear)])
    off = motion.off[:, joint]
    size = np.sqrt(np.mean(features**2, axis=0))
    features = features / np.where(size > 0.0, size, 1.0)
    inverse = np.linalg.pinv(features.T @ features, rcond=1e-10, hermitian=True)
    values = inverse @ (features.T @ off)
    left = features * (off - features @ values)[:, None]
    blocks = np.add.reduceat(left, np.arange(0, len(left), BLOCK), axis=0)
    spread = np.sqrt(np.diag(inverse @ (blocks.T @ blocks) @ inverse))
    return values[:3] / size[:3], np.maximum(spread[:3] / size[:3], 1e-12)
