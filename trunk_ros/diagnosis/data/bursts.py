"""Bursts: stretches in which the sensors of most joints are much louder, as beside a welder."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import fourth_differences
from trunk_ros.diagnosis.levels import ENOUGH, FEWEST, HALF, MOST, NOTABLE

WINDOW = ENOUGH // 2  # samples, of which all joints together tell how loud they are

Burst = tuple[float, float, float]
"""From when until when [s], and how many times as loud as else."""


def bursts(residuals: Sequence[Array], masks: Sequence[np.ndarray], stamp: Array) -> tuple[Burst, ...]:
    """The bursts in what is left of joints, (n,) each, where it counts (n,), at ``stamp`` (n,) s. What rings
    or slides is no noise: that has another sign in nearly every sample.
    """
    count = (len(stamp) - 4) // WINDOW
    if count < FEWEST or not residuals:
        return ()
    seen = [_seen(*each, count) for each in zip(residuals, masks, strict=True)]
    sizes, turns = np.array([size for size, _ in seen]), np.array([turn for _, turn in seen])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # joints and windows in which nothing counts
        times = sizes / np.nanmedian(sizes, axis=1, keepdims=True)
        usual, turning = np.nanmedian(times, axis=0), np.nanmedian(turns, axis=0)
    alike = np.sum(times > NOTABLE, axis=0) > MOST * np.sum(np.isfinite(times), axis=0)
    loud = alike & (usual > NOTABLE) & (turning > MOST)
    if not loud.any() or np.mean(loud) > HALF:
        return ()
    edges = np.flatnonzero(np.diff(np.concatenate([[False], loud, [False]]).astype(int))).reshape(-1, 2)
    return tuple(
        (
            float(stamp[max(first - 1, 0) * WINDOW]),
            float(stamp[min((last + 1) * WINDOW, len(stamp) - 1)]),
            float(np.median(usual[first:last])),
        )
        for first, last in edges
    )


def _seen(residual: Array, mask: np.ndarray, count: int) -> tuple[Array, Array]:
    """Size of the fourth differences in each window (count,), and how often they have another sign than the
    one before.
    """
    difference, whole = fourth_differences(residual, mask)
    turns = np.append(difference[1:] * difference[:-1] < 0.0, False)
    each = (
        np.where(whole, x, np.nan)[: count * WINDOW].reshape(count, WINDOW)
        for x in (np.abs(difference), turns)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        size, turning = np.nanmedian(next(each), axis=1), np.nanmean(next(each), axis=1)
    return np.where(size > 0.0, size, np.nan), turning
