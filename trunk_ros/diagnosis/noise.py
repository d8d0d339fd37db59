"""The noise floor, from the recording itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from trunk_ros.compiled import Array

BINOMIAL = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
MEDIAN_TO_STD = 1.4826
TRIMMED = 0.98658  # std of a normal variable within three of its std
LEAST = 1e-9  # a floor for recordings without any noise
WHITE = 0.06  # correlations below this cannot be told from none


@dataclass(frozen=True)
class Noise:
    """Standard deviation and lag-one correlation of a sensor's noise, an AR(1) process."""

    std: float
    correlation: float = 0.0

    def whiten(self, residual: Array, follows: np.ndarray) -> Array:
        """Residuals (n, ...) as independent unit noise; ``follows`` (n,) where the sample before counts
        as well.
        """
        if self.correlation == 0.0:
            return residual / self.std
        rest = self.std * np.sqrt(1.0 - self.correlation**2)
        out = residual / self.std
        out[1:][follows[1:]] = ((residual[1:] - self.correlation * residual[:-1]) / rest)[follows[1:]]
        return np.asarray(out)


def noise_of(residuals: list[Array], masks: list[np.ndarray], coloured: bool = True) -> Noise:
    """Noise of one signal from fourth differences of its residual at strides one to three, by the median.

    What moves slowly against the sampling cancels in them, and rare kinks do not move a median. Without
    ``coloured``
    the noise is taken as white: samples far apart in time share none.
    """
    spread = [_robust(residuals, masks, stride) for stride in (1, 2, 3)]
    if spread[0] <= LEAST or not coloured:
        return Noise(max(spread[0] / np.sqrt(_gain(0.0, 1)), LEAST))
    correlation = _correlation(spread[1] ** 2 / spread[0] ** 2)
    if correlation < WHITE:
        return Noise(spread[0] / np.sqrt(_gain(0.0, 1)))
    return Noise(spread[0] / np.sqrt(_gain(correlation, 1)), correlation)


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


def _correlation(ratio: float) -> float:
    """The lag-one correlation for which strides two and one differ by this ratio of variances."""

    def off(correlation: float) -> float:
        return _gain(correlation, 2) / _gain(correlation, 1) - ratio

    if off(0.0) >= 0.0:
        return 0.0
    return float(brentq(off, 0.0, 0.97)) if off(0.97) > 0.0 else 0.97
