"""Hum: a steady tone of one frequency and one size in the readings of all joints, whether they move or not,
as mains come through a supply or a cable that the sensors share; sampled, a fast tone is a slow wave.

What physics shakes, it shakes each joint by its own inertia and stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import chdtri

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.sensing.physics import FEWEST, basis, motion_of, scaled
from trunk_ros.diagnosis.discrepancy.spectrum import spectrum
from trunk_ros.diagnosis.levels import CERTAIN, CHANCE, NEARLY, SURE
from trunk_ros.guards import BLIND, TINY
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.resample import SLOW

JOINTS = 3  # of which one size says something
NEAR, FAR = 2, 16  # bins of the spectrum beside a tone that show what else there is
TONES = 3
TURNS = 5.0  # in the recording: what comes back less often may be what happened to the arm, such as a payload


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
    driven = (shown.stamp >= gearbox.stamp[0]) & (shown.stamp <= gearbox.stamp[-1])
    shown = shown.rows(driven)
    if len(shown.stamp) < FEWEST or len(shown.joints) < JOINTS:
        return []
    if float(np.median(np.diff(shown.stamp))) > SLOW / 2:
        return []
    motion = motion_of(gearbox, shown, arm)
    says = [_spanned(scaled(basis(motion, j, True))[0]) for j in range(len(arm.joints))]
    off, found = motion.off, list[Hum]()
    while len(found) < TONES and (more := _tone(motion.stamp, off, motion.asked, says)) is not None:
        off = off - more.at(motion.stamp)
        found.append(more)
    return found


def _spanned(features: Array) -> Array:
    """Orthonormal features (n, fewer) that say the same as features (n, k)."""
    u, size, _ = np.linalg.svd(features, full_matrices=False)
    return np.asarray(u[:, size**2 > BLIND * size[0] ** 2])


def _tone(stamp: Array, off: Array, asked: Array, says: list[Array]) -> Hum | None:
    """The strongest line of what the motion does not say of where each joint is off (n, joints), of the
    middle joint, where it is one of all of them and not of the motion ``asked`` (n, joints) rad; ``says``:
    the motion as orthonormal features.
    """
    rest = [one - u @ (u.T @ one) for one, u in zip(off.T, says, strict=True)]
    frequency = _shared(stamp, rest, says)
    if frequency * float(np.ptp(stamp)) < TURNS:
        return None
    lines = []
    for one, u in zip(rest, says, strict=True):
        wave, spread = _line(frequency, stamp, one[:, None], u)
        if not np.all(np.hypot(*wave) > SURE * spread):
            return None
        lines.append((wave, spread))
    waves, std = (np.concatenate(each, axis=-1) for each in zip(*lines, strict=True))
    sizes = np.hypot(*waves)
    weight = std**-2.0
    mean, known = float(sizes @ weight / weight.sum()), float(weight.sum() ** -0.5)
    unlike = float(np.sum(weight * (sizes - mean) ** 2))
    if mean < CERTAIN * known or SURE * float(np.median(std)) > mean:
        return None
    if unlike > chdtri(len(sizes) - 1, CHANCE) or _driven(frequency, stamp, waves, asked):
        return None
    return Hum(frequency, mean, known, waves)


def _shared(stamp: Array, rest: list[Array], says: list[Array]) -> float:
    """The frequency near that of the middle joint's strongest line by which most of the rests (n,) is
    explained beside features (n, k); 0 where there is no line.
    """
    first = float(np.median([spectrum(stamp, one)[0] for one in rest]))
    if first <= 0.0:
        return 0.0

    def left(frequency: float) -> float:
        turning = _turning(frequency, stamp)
        waves = [np.linalg.qr(turning - u @ (u.T @ turning))[0] for u in says]
        pairs = zip(waves, rest, strict=True)
        return -float(sum(np.sum((wave.T @ one) ** 2) / max(float(one @ one), TINY) for wave, one in pairs))

    width = 0.5 / float(np.ptp(stamp))
    near = max(first - width, 0.5 * width), first + width
    found = minimize_scalar(left, bounds=near, method="bounded", options={"xatol": 0.01 * width})
    return float(found.x)


def _driven(frequency: float, stamp: Array, waves: Array, asked: Array) -> bool:
    """Whether the motion ``asked`` (n, joints) may make the ``waves`` (2, joints): every joint swings with
    that frequency itself, and its wave is as far behind that as the others' are behind theirs.
    """
    own, beside = _line(frequency, stamp, asked, np.empty((len(stamp), 0)))
    behind = np.angle(np.exp(1j * (np.arctan2(*waves) - np.arctan2(*own))) ** 2)
    in_step = float(np.abs(np.mean(np.exp(1j * behind))))
    return bool(np.all(np.hypot(*own) > CERTAIN * beside)) and in_step > NEARLY


def _line(frequency: float, stamp: Array, signals: Array, besides: Array) -> tuple[Array, Array]:
    """Cosine and sine (2, signals) of a frequency in signals (n, signals) beside orthonormal features (n,
    features), and the std of each (signals,), by what there is of frequencies next to it.
    """

    def beside_features(at: float) -> Array:
        turning = _turning(at, stamp)
        return np.asarray(turning - besides @ (besides.T @ turning))

    bins = [k for k in range(-FAR, FAR + 1) if abs(k) > NEAR]
    near = [at for k in bins if (at := frequency + k / float(np.ptp(stamp))) > 0.0]
    power = np.mean([(np.linalg.qr(beside_features(at))[0].T @ signals) ** 2 for at in near], axis=(0, 1))
    turning = beside_features(frequency)
    inverse = np.linalg.inv(turning.T @ turning)
    std = np.sqrt(power * np.trace(inverse) / 2.0)
    return inverse @ (turning.T @ signals), np.maximum(std, 1e-15)


def _turning(frequency: float, stamp: Array) -> Array:
    turn = 2.0 * np.pi * frequency * stamp[:, None]
    return np.hstack([np.cos(turn), np.sin(turn)])
