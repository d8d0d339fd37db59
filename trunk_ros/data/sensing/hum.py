"""Hum: a steady tone of one frequency and one size in the readings of all joints, whether they move or not,
as mains come through a supply or a cable that the sensors share; sampled, a fast tone is a slow wave.

What physics shakes, it shakes each joint by its own inertia and stiffness.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import chdtri

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.data.sensing.band import Band
from trunk_ros.data.sensing.physics import (
    Features,
    Motion,
    motion_of,
    take_off,
    tells_of_clocks,
    while_driven,
)
from trunk_ros.data.spectrum import spectrum
from trunk_ros.guards import BLIND, TINY
from trunk_ros.levels import CERTAIN, CHANCE, HALF, JOINTS, SURE, TENFOLD
from trunk_ros.recording.recording import JointSeries

LINE, BINS = 2, 16  # bins of the spectrum beside a tone that show what else there is
TONES = 3
COMES_BACK = 5.0  # times: what comes back less often may have happened to the arm, such as a payload


@dataclass(frozen=True)
class Hum:
    """A tone of ``frequency`` Hz in all joints, ``size`` rad with its ``std``; ``waves`` (2, joints) rad of
    cosine and sine.
    """

    frequency: float
    size: float
    std: float
    waves: Array

    def at(self, stamp: Array, joints: slice | int = slice(None)) -> Array:
        """(n, joints) rad that it adds to the readings, or (n,) to those of one joint."""
        return np.asarray(_turning(self.frequency, stamp) @ self.waves[:, joints])


def hums(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> list[Hum]:
    """The tones in the readings of all joints, of series with the same joints."""
    shown = while_driven(gearbox, shown)
    if len(shown.joints) < JOINTS or not tells_of_clocks(shown):
        return []
    motion = motion_of(gearbox, shown, arm)
    found = list[Hum]()

    def features(joint: int) -> Features:
        return Features.of(motion, joint, motion.speed[:, joint])  # which late readings show

    while len(found) < TONES:
        off = (_but_for(found, motion, joint) for joint in range(len(shown.joints)))
        more = tone(motion.stamp, off, motion.asked.T, features, COMES_BACK)
        if more is None:
            break
        found.append(more)
    return found


def _but_for(found: list[Hum], motion: Motion, joint: int) -> Array:
    """(n,) that a joint is off but for tones that were found."""
    off = motion.shown[:, joint] - motion.asked[:, joint]
    for hum in found:
        off -= hum.at(motion.stamp, joint)
    return np.asarray(off)


@dataclass(frozen=True)
class _Waves:
    """What waves of nearly one frequency share with signals, beside features that say something of them."""

    own: list[Band]
    """Of each signal, and in the columns after it of its features."""
    mixes: list[Array]
    """By which each signal's features are orthonormal."""
    twice: Band
    """Of a one at twice the frequency."""
    count: int

    def at(self, frequency: float) -> Iterator[tuple[Array, Array]]:
        """Of each signal (2, 2) squares of cosine and sine beside its features, and (2,) what these share
        with the signal, of which the features explain nothing.
        """
        (cosine,), (sine,) = self.twice.at(2.0 * frequency)
        whole = 0.5 * np.array([[self.count + cosine, sine], [sine, self.count - cosine]])
        for band, mix in zip(self.own, self.mixes, strict=True):
            both = band.at(frequency)
            along = both[:, 1:] @ mix
            power, way = np.linalg.eigh(whole - along @ along.T)
            yield (way * np.maximum(power, BLIND * self.count)) @ way.T, both[:, 0]

    def power(self, frequency: float) -> Array:
        """(signals,) squares of the signals that waves of a frequency explain."""
        return np.array([both @ np.linalg.solve(square, both) for square, both in self.at(frequency)])


def tone(
    stamp: Array,
    off: Iterable[Array],
    asked: Iterable[Array],
    features: Callable[[int], Array | Features],
    least: float,
) -> Hum | None:
    """The strongest line of what ``features`` (n, k) of a joint do not say of where each joint is ``off``
    (n,), of the middle joint, where it is one of all of them, comes back so many times at ``least``, and is
    not of the motion (n,) that each was ``asked``.

    All of these are made when they are needed: those of all joints are as large as all else.
    """
    pairs = [_beside(features(j), one) for j, one in enumerate(off)]
    rests, mixes = [rest for rest, _ in pairs], [mix for _, mix in pairs]
    first = float(np.median([spectrum(stamp, rest)[0] for rest in rests]))
    if first <= 0.0:
        return None
    own = [Band.of(stamp, first, rest[:, None], features(j)) for j, rest in enumerate(rests)]
    twice = Band.of(stamp, 2.0 * first, np.ones((len(stamp), 1)))
    waves = _Waves(own, mixes, twice, len(stamp))
    frequency = _shared(stamp, waves, np.array([float(rest @ rest) for rest in rests]), first)
    if frequency * float(np.ptp(stamp)) < least:
        return None
    seen, std = _lines(frequency, stamp, waves)
    sizes = np.hypot(*seen)
    if not np.all(sizes > SURE * std):
        return None
    weight = std**-2.0
    mean, known = float(sizes @ weight / weight.sum()), float(weight.sum() ** -0.5)
    unlike = float(np.sum(weight * (sizes - mean) ** 2))
    if mean < CERTAIN * known or CERTAIN * float(np.median(std)) > mean:  # else any sizes are alike
        return None
    if unlike > chdtri(len(sizes) - 1, CHANCE) or _driven(frequency, stamp, list(asked)):
        return None
    return Hum(frequency, mean, known, seen)


def _beside(features: Array | Features, one: Array) -> tuple[Array, Array]:
    """What features (n, k) do not say of a signal (n,), and the mixtures by which they are orthonormal."""
    rest = one.copy()
    return rest, take_off(features, rest)


def _shared(stamp: Array, waves: _Waves, power: Array, first: float) -> float:
    """The frequency near the ``first`` look's by which most of the signals of so much ``power`` (signals,) is
    explained.
    """
    width = 0.5 / float(np.ptp(stamp))
    near = max(first - width, 0.5 * width), first + width
    found = minimize_scalar(
        lambda at: -float(np.sum(waves.power(at) / np.maximum(power, TINY))),
        bounds=near,
        method="bounded",
        options={"xatol": 0.01 * width},
    )
    return float(found.x)


def _driven(frequency: float, stamp: Array, asked: list[Array]) -> bool:
    """Whether motions (n,) that were ``asked`` may make waves of a frequency: most joints swing with it,
    whose load bears on all, or so many times more slowly, as friction makes overtones of a swing; every one,
    where a line is too slow to stand out from what is slower.
    """
    times = frequency * float(np.ptp(stamp)) / COMES_BACK
    if times <= 1.0:
        return bool(_swings(frequency, stamp, asked).all())
    slower = range(1, 1 + int(min(times, TENFOLD)))
    return any(np.mean(_swings(frequency / k, stamp, asked)) > HALF for k in slower)


def _swings(frequency: float, stamp: Array, asked: list[Array]) -> np.ndarray:
    """(signals,) whether each swings at a frequency."""
    plain = [Band.of(stamp, frequency, one[:, None]) for one in asked]
    twice = Band.of(stamp, 2.0 * frequency, np.ones((len(stamp), 1)))
    own, beside = _lines(frequency, stamp, _Waves(plain, [np.empty((0, 0))] * len(plain), twice, len(stamp)))
    return np.asarray(np.hypot(*own) > SURE * beside)


def _lines(frequency: float, stamp: Array, waves: _Waves) -> tuple[Array, Array]:
    """Cosine and sine (2, signals) of a frequency in signals beside features, and the std of each (signals,),
    by what there is of frequencies next to it.
    """
    bins = [k for k in range(-BINS, BINS + 1) if abs(k) > LINE]
    near = [at for k in bins if (at := frequency + k / float(np.ptp(stamp))) > 0.0]
    power = np.mean([waves.power(at) for at in near], axis=0) / 2.0
    inverse = [(np.linalg.inv(square), both) for square, both in waves.at(frequency)]
    std = np.sqrt(power * [np.trace(each) / 2.0 for each, _ in inverse])
    return np.column_stack([each @ both for each, both in inverse]), np.maximum(std, 1e-15)


def _turning(frequency: float, stamp: Array) -> Array:
    turn = 2.0 * np.pi * frequency * stamp[:, None]
    return np.hstack([np.cos(turn), np.sin(turn)])
