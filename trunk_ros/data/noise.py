"""The noise floor, from the recording itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import erf, exp, pi, sqrt
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.innovations import innovations, innovations_of_two, unlikely
from trunk_ros.guards import ROUNDS, SAME
from trunk_ros.levels import SURE, TENFOLD
from trunk_ros.recording.signal.encoder import MEDIAN_TO_STD
from trunk_ros.recording.signal.resample import SLOW

BINOMIAL = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
TRIMMED = round(sqrt(1.0 - 6.0 * exp(-4.5) / sqrt(2.0 * pi) / erf(3.0 / sqrt(2.0))), 5)
"""Standard deviation of a normal variable within three of its standard deviations."""
REMEMBERED = 0.16  # s that noise is compared over
OFTEN = 0.02  # s between samples that show what lies between them
FLOOR = 1e-9  # a floor for recordings without any noise
WHITE = 0.06  # correlations below this cannot be told from none
REDDEST = 0.985  # correlation
CORRELATIONS = np.linspace(0.0, REDDEST, 24)
DIFFERENCED = np.correlate(BINOMIAL, BINOMIAL, "full")[: len(BINOMIAL)] * [2, 2, 2, 2, 1]
"""Variance of a fourth difference over that of a signal, as a polynomial of its correlation at one stride."""
BEND = 2.0 * (len(BINOMIAL) - 1)
"""Power of the stride with which the variance of a smooth signal's fourth difference grows."""
TELLING = 4  # strides that tell motion from noise
STRIDES = (1, 2, 3, 4, 6, 8, 12, 16)


def is_none(std: float) -> bool:
    """Whether a standard deviation is that of rounding, and nothing can be told in times of it."""
    return std < TENFOLD * FLOOR


@dataclass(frozen=True)
class Noise:
    """Standard deviation of a sensor's noise: an AR(1) process of a lag-one correlation, with a ``white``
    part on top (a standard deviation, too), which an encoder's steps add; and a ``slow`` part (standard
    deviation, correlation) where it wanders over many times at once, as 1/f noise does.
    """

    std: float
    correlation: float = 0.0
    white: float = 0.0
    slow: tuple[float, float] = (0.0, 0.0)

    def of_every(self, readings: int) -> Noise:
        """That of one of so many readings: what cannot be told from none is no correlation."""
        (std, slow), own = self.slow, self.correlation**readings
        return replace(self, correlation=own if own > WHITE else 0.0, slow=(std, slow**readings))

    @property
    def goes_on(self) -> float:
        """Covariance of one sample with the next."""
        return self.correlation * self._coloured + self.slow[0] ** 2 * self.slow[1]

    @property
    def remembers(self) -> float:
        """Correlation of the part that goes on longest."""
        return max(self.correlation, self.slow[1] if self.slow[0] > 0.0 else 0.0)

    @property
    def roughness(self) -> float:
        """Standard deviation of the white noise whose fourth differences are as large."""
        smooth = self._coloured * _gain(self.correlation, 1) + self.slow[0] ** 2 * _gain(self.slow[1], 1)
        return sqrt(smooth / _gain(0.0, 1) + self.white**2)

    @property
    def _coloured(self) -> float:
        return self.std**2 - self.white**2 - self.slow[0] ** 2

    def whiten(self, residual: Array, follows: np.ndarray) -> Array:
        """A residual (n,) as independent unit noise; ``follows`` (n,) where the sample before counts as
        well.
        """
        if self.remembers == 0.0:
            return residual / self.std
        return self._innovations(residual, follows)[0]

    def unlikely(self, residual: Array, follows: np.ndarray, counted: np.ndarray) -> float:
        """Twice the negative logarithm of a residual's likelihood at the rows that are ``counted``, but for a
        constant.
        """
        return unlikely(*self._innovations(residual, follows), counted)

    def _innovations(self, residual: Array, follows: np.ndarray) -> tuple[Array, Array]:
        out, spread = np.empty(len(residual)), np.empty(len(residual))
        if self.slow[0] == 0.0:
            innovations(residual, follows, self.correlation, self._coloured, self.white**2, out, spread)
        else:
            parts = self.correlation, self._coloured, self.slow[1], self.slow[0] ** 2
            innovations_of_two(residual, follows, *parts, self.white**2, out, spread)
        return out, spread


@dataclass(frozen=True)
class Differences:
    """Standard deviations of a residual's fourth differences at growing strides (k,); of ``white`` noise of a
    known standard deviation is in them.
    """

    strides: tuple[int, ...]
    spread: Array
    white: float = 0.0
    count: int = 0
    """How many there are at the shortest stride."""

    @property
    def swings(self) -> bool:
        """Whether they shrink somewhere as the stride grows: those of noise never do, and what rings goes on
        for longer than its noise can be told from it.
        """
        power = self.spread**2
        off = np.array([off_by_chance(self.count // stride) for stride in self.strides])
        return bool(((power * (1.0 + off))[1:] < (power * (1.0 - off))[:-1]).any())

    @property
    def correlation(self) -> float:
        """Lag-one correlation of the AR(1) noise whose fourth differences grow likest with the stride, beside
        what is left of the motion.

        What jumps or bends in the motion grows as slowly as noise, and makes it too large.
        """
        grid = CORRELATIONS
        for _ in range(2):
            best = int(np.argmin(self._fitted(grid)[1]))
            around = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
            found, grid = float(grid[best]), np.linspace(*around, len(CORRELATIONS))
        off = self._fitted(np.array([found, 0.0]))[1]
        return found if found > WHITE and off[0] < off[1] else 0.0

    def noise(self, correlation: float) -> Noise:
        """Noise of that correlation, of the size seen at the shortest stride, or at all where a part is
        white.
        """
        if correlation == 0.0 or self.white == 0.0:
            return Noise(max(float(self.spread[0]) / np.sqrt(_gain(correlation, 1)), FLOOR), correlation)
        coloured = float(self._fitted(np.array([correlation]))[0][0])
        return Noise(max(float(np.hypot(coloured, self.white)), FLOOR), correlation, self.white)

    def _fitted(self, correlations: Array) -> tuple[Array, Array]:
        """For each of some correlations (k,) the standard deviation of the AR(1) noise that is likest beside
        the white part and beside a motion that is smooth, whose fourth differences grow with the fourth power
        of the stride; and how far the logarithms of the variances are off.
        """
        strides = np.asarray(self.strides, dtype=np.float64)
        near, seen = 1.0 / strides, 2.0 * np.log(self.spread)
        gain = np.array([_gain(correlations, stride) for stride in strides]).T
        steps = BINOMIAL @ BINOMIAL * self.white**2
        size = seen[0] - np.log(gain[:, 0])
        motion = np.full(len(size), seen[-1] - BEND * np.log(strides[-1]) - np.log(2.0))
        if len(strides) < TELLING:
            motion[:] = -np.inf
        for _ in range(ROUNDS):
            coloured, smooth = np.exp(size)[:, None] * gain, np.exp(motion)[:, None] * strides**BEND
            whole = coloured + smooth + steps
            rest, p, q = seen - np.log(whole), coloured / whole, smooth / whole
            pp, pq, qq = (near * p * p).sum(1) + SAME, (near * p * q).sum(1), (near * q * q).sum(1) + SAME
            up, vp = (near * p * rest).sum(1), (near * q * rest).sum(1)
            size = size + np.clip((qq * up - pq * vp) / (pp * qq - pq**2), -1.0, 1.0)
            motion = motion + np.clip((pp * vp - pq * up) / (pp * qq - pq**2), -2.0, 2.0)
        return np.exp(0.5 * size), np.asarray((near * rest**2).sum(1))


def differences_of(
    residuals: list[Array], masks: list[np.ndarray], longest: int = 1, white: float = 0.0
) -> Differences:
    """Fourth differences of one signal at strides up to ``longest`` samples, by the median; of its noise a
    ``white`` part is known.

    What moves slowly against the sampling cancels in them, and rare kinks do not move a median.
    """
    strides = tuple(s for s in STRIDES if s <= longest)
    spread = np.array([_robust(residuals, masks, s) for s in strides])
    known = max(int(np.argmin(spread > FLOOR)) if (spread <= FLOOR).any() else len(strides), 1)
    count = sum(int(mask.sum()) for mask in masks)
    return Differences(strides[:known], np.maximum(spread[:known], FLOOR), white, count)


def strides_within(step: float) -> int:
    """The longest stride, in samples ``step`` s apart, at which what is left of the motion still cancels."""
    return max(1, int(REMEMBERED / max(step, 1e-6))) if step < SLOW else 1


@cache
def off_by_chance(count: int) -> float:
    """How far white noise's power by fourth differences of so many samples may be off, as a share of it."""
    shared = np.correlate(BINOMIAL, BINOMIAL, "full") / (BINOMIAL @ BINOMIAL)
    return SURE * float(np.sqrt(2.0 * (shared @ shared) / max(count, 1)))


def known_to(noise: Noise, count: int, step: float) -> float:
    """Share of its power to which noise is known by so many samples, ``step`` s apart."""
    white = noise.remembers == 0.0 and step < OFTEN
    return max(0.1 if white else 0.6, off_by_chance(count))


def noise_of(residuals: list[Array], masks: list[np.ndarray], longest: int = STRIDES[-1]) -> Noise:
    """Noise of one signal, by the residuals (n,) of each recording and where they count (n,); white where
    ``longest`` is 1 sample.
    """
    seen = differences_of(residuals, masks, longest)
    return seen.noise(seen.correlation if len(seen.strides) > 1 else 0.0)


def alike(residuals: list[Array]) -> float:
    """How many samples are worth one, by what a residual remembers: 1 and twice the autocorrelation at all
    lags until it is lost in chance.
    """
    power = sum(float(rest @ rest) for rest in residuals)
    count = sum(len(rest) for rest in residuals)
    total = 1.0
    for lag in range(1, count // 10 if power > 0.0 else 0):
        shared = sum(float(rest[lag:] @ rest[:-lag]) for rest in residuals) / power
        if shared < 2.0 / np.sqrt(count):
            break
        total += 2.0 * shared
    return total


def fourth_differences(residual: Array, mask: np.ndarray, stride: int = 1) -> tuple[Array, np.ndarray]:
    """(n - 4 stride,) of unit variance in white unit noise, of a residual (n,), and where all of it counts;
    ``mask`` (n,).
    """
    ends = max(len(residual) - 4 * stride, 0)
    parts = [slice(k * stride, ends + k * stride) for k in range(len(BINOMIAL))]
    difference = sum((c * residual[part] for c, part in zip(BINOMIAL, parts, strict=True)), np.zeros(ends))
    return difference, np.all([mask[part] for part in parts], axis=0)


def roughness_of(readings: list[Array], masks: list[np.ndarray]) -> float:
    """The most white noise that readings (n,) of each recording can hold, where they count (n,): all that
    they are rough by, the motion too.
    """
    rough = np.append(_counted_differences(readings, masks), 0.0)
    return rms(rough) / float(np.linalg.norm(BINOMIAL))


def _robust(residuals: list[Array], masks: list[np.ndarray], stride: int) -> float:
    joined = np.abs(_counted_differences(residuals, masks, stride))
    return trimmed(joined) if joined.size else 0.0


def _counted_differences(signals: list[Array], masks: list[np.ndarray], stride: int = 1) -> Array:
    """Fourth differences of all recordings, where they count."""
    seen = (fourth_differences(*each, stride) for each in zip(signals, masks, strict=True))
    return np.concatenate([np.empty(0), *(difference[whole] for difference, whole in seen)])


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def trimmed(size: Array) -> float:
    """Standard deviation of what lies within three of it, starting from the median: a tenth of its
    scatter.
    """
    std = float(MEDIAN_TO_STD * np.median(size))
    for _ in range(5):
        inside = size[size <= 3.0 * std]
        if not inside.size:
            return std
        std = rms(inside) / TRIMMED
    return std


def _gain(correlation: Any, stride: float) -> Any:
    """Variance of the fourth difference over that of AR(1) noise."""
    return np.polyval(DIFFERENCED, np.power(correlation, stride))
