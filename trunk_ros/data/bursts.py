"""Bursts: stretches in which the sensors of most joints are much louder, as beside a welder."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import fourth_differences
from trunk_ros.levels import CHANCE, ENOUGH, FEWEST, HALF, MOST, NOTABLE
from trunk_ros.recording.signal.gaps import runs

WINDOW = ENOUGH // 2  # samples, of which all joints together tell how loud they are

Burst = tuple[float, float, float]
"""From when until when [s], and how many times as loud as else."""


def bursts(
    residuals: Sequence[Array], masks: Sequence[np.ndarray], stamp: Array, speeds: Sequence[Array] = ()
) -> tuple[Burst, ...]:
    """The bursts in what is left of joints, (n,) each, where it counts (n,), at ``stamp`` (n,) s. What rings
    or slides is no noise: that has another sign in nearly every sample. Nor is what always comes with the
    motion, going by ``speeds`` (n,) rad/s: what is outside does not know of it.
    """
    count = (len(stamp) - 4) // WINDOW
    if count < FEWEST or not residuals:
        return ()
    seen = [_windows(*each, count) for each in zip(residuals, masks, strict=True)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # joints and windows in which nothing counts
        sizes = np.array([np.nanmedian(size, axis=1) for size, _ in seen])
        turns = np.array([np.nanmean(turn, axis=1) for _, turn in seen])
        sizes[sizes == 0.0] = np.nan
        times = sizes / np.nanmedian(sizes, axis=1, keepdims=True)
        usual, turning = np.nanmedian(times, axis=0), np.nanmedian(turns, axis=0)
    alike = np.sum(times > NOTABLE, axis=0) > MOST * np.sum(np.isfinite(times), axis=0)
    loud = alike & (usual > NOTABLE) & (turning > MOST)
    if not loud.any() or np.mean(loud) > HALF or _comes_with(loud, speeds):
        return ()
    return tuple(
        (
            float(stamp[max(first - 1, 0) * WINDOW]),
            float(stamp[min((last + 1) * WINDOW, len(stamp) - 1)]),
            float(np.median(usual[first:last])),
        )
        for first, last in runs(loud)
    )


def _comes_with(loud: np.ndarray, speeds: Sequence[Array]) -> bool:
    """Whether windows (count,) that are ``loud`` are those in which a joint is fast, or gains speed. Each row
    of them counts once, as what moves a joint goes on. Source: Mann & Whitney (1947), Ann. Math. Statist.
    18(1).
    """
    from scipy.stats import mannwhitneyu, norm  # of few recordings: importing it takes 25 MB

    rows = 1 + int(np.count_nonzero(np.diff(loud.astype(int))))
    some, others = (rows + 1) // 2, rows // 2
    if not others:
        return False
    least = norm.isf(CHANCE / (4 * max(len(speeds), 1)))
    scatter = np.sqrt((some + others + 1) / (12.0 * some * others))
    return any(
        abs(mannwhitneyu(size[loud], size[~loud]).statistic / (loud.sum() * (~loud).sum()) - HALF)
        > least * scatter
        for speed in speeds
        for size in (_sizes(speed, len(loud)), _sizes(np.gradient(speed), len(loud)))
    )


def _sizes(signal: Array, count: int) -> Array:
    """(count,) the usual size of a signal (n,) in each window."""
    return np.asarray(np.median(np.abs(signal[: count * WINDOW]).reshape(count, WINDOW), axis=1))


def _windows(residual: Array, mask: np.ndarray, count: int) -> tuple[Array, Array]:
    """Sizes of the fourth differences in each window (count, WINDOW), and whether each has another sign than
    the one before; NaN where not all of it counts.
    """
    difference, whole = fourth_differences(residual, mask)
    turns = np.append(difference[1:] * difference[:-1] < 0.0, False)
    size, turn = (np.where(whole, x, np.nan)[: count * WINDOW] for x in (np.abs(difference), turns))
    return size.reshape(count, WINDOW), turn.reshape(count, WINDOW)
