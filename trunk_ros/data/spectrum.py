"""The strongest line in a residual over time."""

from __future__ import annotations

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.optimize import minimize_scalar

from trunk_ros.compiled import Array
from trunk_ros.levels import NEARLY, SEVERAL, TENFOLD, TURNS
from trunk_ros.machine import precision

FINER = 4  # steps of a first look to each line's width, by which two waves part by a period


def spectrum(stamp: Array, residual: Array) -> tuple[float, float]:
    """(frequency Hz, share of the power) of the strongest line in a residual (n,) at uneven stamps (n,), up
    to half the sampling rate.
    """
    whole = _longest(stamp)
    stamp, off = stamp[whole], residual[whole] - residual[whole].mean()
    if len(stamp) < 2:
        return 0.0, 0.0
    step, span = float(np.median(np.diff(stamp))), float(stamp[-1] - stamp[0])
    low, high = SEVERAL / span, 0.5 / step - 1.0 / span
    if high <= low or not np.any(off):
        return 0.0, 0.0
    cell = np.round((stamp - stamp[0]) / step).astype(int)
    even = np.bincount(cell, weights=off) / np.maximum(np.bincount(cell), 1)
    size = next_fast_len(FINER * len(even))
    lines = np.abs(rfft(even.astype(precision(len(even)), copy=False), size))
    least, most = int(np.ceil(low * size * step)), int(high * size * step)
    first = (least + int(np.argmax(lines[least : most + 1]))) / (size * step)
    near = (max(first - 0.5 / span, low), min(first + 0.5 / span, high))
    best = minimize_scalar(lambda f: -_explained(f, stamp, off), bounds=near, method="bounded",
                           options={"xatol": 1e-4 / span})  # fmt: skip
    return float(best.x), float(-best.fun)


def repeats_in(motion: Array, stamp: Array, period: float, parts: int) -> bool:
    """Whether one of motors (n, motors) goes through the same at ``stamp`` (n,) s again and again, in a
    period or a few of them, looked at in so many ``parts``: what swings with that may be of the motion as
    well as of time.
    """
    for times in range(1, TURNS + 1):
        if times * period > (stamp[-1] - stamp[0]) / SEVERAL:
            break
        phase = (stamp / (times * period) % 1.0 * parts).astype(int) % parts
        count = np.maximum(np.bincount(phase, minlength=parts), 1)
        for course in (motion - motion.mean(axis=0)).T:
            sums = np.bincount(phase, weights=course, minlength=parts)
            if float(course @ course) > 0.0 and np.sum(sums**2 / count) > NEARLY * float(course @ course):
                return True
    return False


def _longest(stamp: Array) -> slice:
    """All samples, or where most of the time is gaps, the most that follow each other without a long one."""
    step = np.diff(stamp)
    usual = float(np.median(step)) if len(step) else 0.0
    if not len(step) or stamp[-1] - stamp[0] < TENFOLD * usual * len(stamp):
        return slice(None)
    ends = np.concatenate([[0], 1 + np.flatnonzero(step > TENFOLD * usual), [len(stamp)]])
    longest = int(np.argmax(np.diff(ends)))
    return slice(int(ends[longest]), int(ends[longest + 1]))


def _explained(frequency: float, stamp: Array, off: Array) -> float:
    """Share of the power of ``off`` (n,) that a sine of a frequency takes up."""
    turn = 2 * np.pi * frequency * stamp
    waves = np.empty((2, len(turn)))
    np.cos(turn, out=waves[0])
    np.sin(turn, out=waves[1])
    both = waves @ off
    return float(both @ np.linalg.solve(waves @ waves.T, both) / (off @ off))
