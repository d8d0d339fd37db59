"""The noise floor, from the recording itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from trunk_ros.compiled import Array
from trunk_ros.recording.signal.encoder import MEDIAN_TO_STD
from trunk_ros.recording.signal.resample import SLOW

BINOMIAL = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
TRIMMED = 0.98658  # std of a normal variable within three of its std
REMEMBERED = 0.16  # s that noise is compared over
LEAST = 1e-9  # a floor for recordings without any noise
WHITE = 0.06  # correlations below this cannot be told from none
MOST = 0.985  # correlation
ROUNDS = 12
STRIDES = (1, 2, 3, 4, 6, 8, 12, 16)


@dataclass(frozen=True)
class Noise:
    """Standard deviation of a sensor's noise: an AR(1) process of a lag-one correlation, with a ``white``
    part on top (a standard deviation, too), which an encoder's steps add.
    """

    std: float
    correlation: float = 0.0
    white: float = 0.0

    def whiten(self, residual: Array, follows: np.ndarray) -> Array:
        """Residuals (n, ...) as independent unit noise; ``follows`` (n,) where the sample before counts
        as well.
        """
        if self.correlation == 0.0:
            return residual / self.std
        coloured, square = self.std**2 - self.white**2, self.correlation**2
        rest = np.sqrt(coloured * (1.0 - square) + self.white**2 * (1.0 + square))
        out = residual / self.std
        out[1:][follows[1:]] = ((residual[1:] - self.correlation * residual[:-1]) / rest)[follows[1:]]
        return np.asarray(out)


@dataclass(frozen=True)
class Differences:
    """Standard deviations of a residual's fourth differences at growing strides (k,); of ``white`` noise of a
    known standard deviation is in them.
    """

    strides: tuple[int, ...]
    spread: Array
    white: float = 0.0

    @property
    def correlation(self) -> float:
        """Lag-one correlation of the AR(1) noise whose fourth differences grow likest with the stride.

        What is left of the motion grows faster still, and makes it too large.
        """

        def off(correlation: float) -> float:
            return self._fitted(correlation)[1]

        found = float(minimize_scalar(off, bounds=(0.0, MOST), method="bounded").x)
        return found if found > WHITE and off(found) < off(0.0) else 0.0

    def noise(self, correlation: float) -> Noise:
        """Noise of that correlation, of the size seen at the shortest stride, or at all where a part is
        white.
        """
        if correlation == 0.0 or self.white == 0.0:
            return Noise(max(float(self.spread[0]) / np.sqrt(_gain(correlation, 1)), LEAST), correlation)
        coloured = self._fitted(correlation)[0]
        return Noise(max(float(np.hypot(coloured, self.white)), LEAST), correlation, self.white)

    def _fitted(self, correlation: float) -> tuple[float, float]:
        """Standard deviation of AR(1) noise of a correlation that is likest beside the white part, and how
        far the logarithms of the variances are off.
        """
        near = 1.0 / np.asarray(self.strides)
        gain = np.array([_gain(correlation, s) for s in self.strides])
        steps, size = (
            BINOMIAL @ BINOMIAL * self.white**2,
            2.0 * float(np.log(self.spread[0])) - float(np.log(gain[0])),
        )
        for _ in range(ROUNDS):
            coloured = np.exp(size) * gain
            rest = 2.0 * np.log(self.spread) - np.log(coloured + steps)
            share = coloured / (coloured + steps)
            size += float(np.clip(near * share @ rest / (near * share @ share), -1.0, 1.0))
        rest = 2.0 * np.log(self.spread) - np.log(np.exp(size) * gain + steps)
        return float(np.exp(0.5 * size)), float(near @ rest**2)


def differences_of(
    residuals: list[Array], masks: list[np.ndarray], longest: int = 1, white: float = 0.0
) -> Differences:
    """Fourth differences of one signal at strides up to ``longest`` samples, by the median; of its noise a
    ``white`` part is known.

    What moves slowly against the sampling cancels in them, and rare kinks do not move a median.
    """
    strides = tuple(s for s in STRIDES if s <= longest)
    spread = np.array([_robust(residuals, masks, s) for s in strides])
    known = int(np.argmin(spread > LEAST)) if (spread <= LEAST).any() else len(strides)
    return Differences(strides[: max(known, 1)], np.maximum(spread[: max(known, 1)], LEAST), white)


def strides_within(step: float) -> int:
    """The longest stride, in samples ``step`` s apart, at which what is left of the motion still cancels."""
    return max(1, int(REMEMBERED / max(step, 1e-6))) if step < SLOW else 1


def noise_of(residuals: list[Array], masks: list[np.ndarray], longest: int = 16) -> Noise:
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


def _robust(residuals: list[Array], masks: list[np.ndarray], stride: int) -> float:
    parts = []
    for residual, mask in zip(residuals, masks, strict=True):
        if len(residual) > 4 * stride:
            ends = len(residual) - 4 * stride
            whole = np.all([mask[k * stride : ends + k * stride] for k in range(5)], axis=0)
            difference = sum(c * residual[k * stride : ends + k * stride] for k, c in enumerate(BINOMIAL))
            parts.append(np.abs(difference[whole]))
    joined = np.concatenate(parts) if parts else np.empty(0)
    return _trimmed(joined) if joined.size else 0.0


def _trimmed(size: Array) -> float:
    """Standard deviation of what lies within three of it, starting from the median: a tenth of its
    scatter.
    """
    std = float(MEDIAN_TO_STD * np.median(size))
    for _ in range(5):
        inside = size[size <= 3.0 * std]
        if not inside.size:
            return std
        std = float(np.sqrt(np.mean(inside**2)) / TRIMMED)
    return std


def _gain(correlation: float, stride: int) -> float:
    """Variance of the fourth difference over that of AR(1) noise."""
    lags = np.abs(np.subtract.outer(np.arange(5), np.arange(5))) * stride
    return float(BINOMIAL @ np.power(correlation, lags) @ BINOMIAL)
