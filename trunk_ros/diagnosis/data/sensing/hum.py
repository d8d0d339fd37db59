"""Hum: a steady tone of one frequency and one size in the readings of all joints, whether they move or not,
as mains come through a supply or a cable that the sensors share; sampled, a fast tone is a slow wave.

What physics shakes, it shakes each joint by its own inertia and stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.sensing.physics import basis, motion_of
from trunk_ros.diagnosis.discrepancy.spectrum import spectrum
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.resample import SLOW

FEWEST = 200  # samples
JOINTS = 3  # of which one size says something
SURE = 6.0  # standard deviations that the tone of each joint stands out of what is beside it
ALIKE = 0.99  # by chance so many sizes of one tone differ less
SHARP = 0.1  # of the size: its std, so that being alike says something
NEAR, FAR = 2, 16  # bins of the spectrum beside a tone that show what else there is
TONES = 3


@dataclass(frozen=True)
class Hum:
    """A tone of ``frequency`` Hz in all joints, ``size`` rad with its ``std``; ``waves`` (2, joints) rad of
    cosine and sine.
    """

    frequency: float
    size: float
    std: float
    waves: Array

    def at(self, stamp: Array) -> Array:
        """(n, joints) rad that it adds to the readings."""
        return np.asarray(_turning(self.frequency, stamp) @ self.waves)


def hums(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> list[Hum]:
    """The tones in the readings of all joints, of series with the same joints."""
    if len(shown.stamp) < FEWEST or len(shown.joints) < JOINTS:
        return []
    if float(np.median(np.diff(shown.stamp))) > SLOW / 2:
        return []
    motion = motion_of(gearbox, shown, arm)
    moves = [_scaled(basis(motion, j, True)) for j in range(len(arm.joints))]
    rest = np.stack([_beyond(moves[j], off) for j, off in enumerate(motion.off.T)], axis=1)
    found: list[Hum] = []
    while len(found) < TONES and (more := _tone(motion.stamp, rest, np.hstack(moves))) is not None:
        rest = rest - more.at(motion.stamp)
        found.append(more)
    return found


def _scaled(features: Array) -> Array:
    size = np.sqrt(np.mean(features**2, axis=0))
    return np.asarray(features / np.where(size > 0.0, size, 1.0))


def _beyond(features: Array, off: Array) -> Array:
    """(n,) what features (n, k) do not say of ``off`` (n,)."""
    return np.asarray(off - features @ np.linalg.lstsq(features, off, rcond=1e-10)[0])


def _tone(stamp: Array, rest: Array, moves: Array) -> Hum | None:
    """The strongest line of what is left (n, joints), of the middle joint, where it is one of all of them and
    not of what the motion does (n, features).
    """
    frequency = float(np.median([spectrum(stamp, one)[0] for one in rest.T]))
    if frequency <= 0.0:
        return None
    waves, std = _line(frequency, stamp, rest)
    sizes = np.hypot(*waves)
    if not np.all(sizes > SURE * std):
        return None
    weight = std**-2.0
    mean = float(sizes @ weight / weight.sum())
    unlike = float(np.sum(weight * (sizes - mean) ** 2))
    if float(np.median(std)) > SHARP * mean or unlike > chi2.ppf(ALIKE, len(sizes) - 1):
        return None
    own, beside = _line(frequency, stamp, moves)
    if np.any(np.hypot(*own) > SURE * beside):
        return None
    return Hum(frequency, mean, float(weight.sum() ** -0.5), waves)


def _line(frequency: float, stamp: Array, signals: Array) -> tuple[Array, Array]:
    """Cosine and sine (2, signals) of a frequency in some signals (n, signals), and what each is of
    frequencies beside it (signals,) rms.
    """
    bins = [k for k in range(-FAR, FAR + 1) if abs(k) > NEAR]
    beside = [_waves(frequency + k / float(np.ptp(stamp)), stamp, signals) for k in bins]
    std = np.sqrt(np.mean([np.mean(w**2, axis=0) for w in beside], axis=0))
    return _waves(frequency, stamp, signals), np.maximum(std, 1e-15)


def _waves(frequency: float, stamp: Array, signals: Array) -> Array:
    """(2, signals) of cosine and sine."""
    turning = _turning(frequency, stamp)
    return np.asarray(np.linalg.solve(turning.T @ turning, turning.T @ signals))


def _turning(frequency: float, stamp: Array) -> Array:
    turn = 2.0 * np.pi * frequency * stamp[:, None]
    return np.hstack([np.cos(turn), np.sin(turn)])
