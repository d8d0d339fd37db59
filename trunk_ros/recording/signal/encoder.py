"""Angles between the counts of an encoder, or within its noise: the smoothest that its readings allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from trunk_ros.recording.recording import Floats, JointSeries
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.resample import stops_to_measure

WINDOWS = (3, 5, 7, 9, 13, 17, 23, 33, 47, 65)  # samples, the longest that fits counts
CURVED = 2  # order of the polynomial in a window
KINDS = 4  # different steps, in counts, from which a grid of readings is an encoder's and no accident
VARIES = 0.02  # of the steps that are unlike the one before: at constant speed all are alike without rounding
MANY = 50  # different readings of a slow joint that tell its grid: a list of postures has fewer
ON_GRID = 0.02  # counts
LEAST = 1e-9  # what readings differ by that are not the same
BEGUN = np.array([0.0, 0.25, 0.5, 0.75, 1.0])  # printed steps by which the least distance may be rounded down
REACHES = (*(5.0 * 6.0 ** np.arange(6)), np.inf)  # counts: each no further than the one before tells the step
NEAR = 0.55  # counts that a reading may lie from a curve through it and its neighbours
CALM = 200  # samples in which a joint may hardly move
CALMEST = 0.2  # share of such stretches
HIDDEN = 0.7  # of a count: more than rounding alone scatters by
REACH = 7.0  # standard deviations of noise that stand for a count: readings lie within four of a curve
ALTERNATES = -0.3  # correlation of fourth differences' signs with the next ones: -0.6 of white noise
EXACT = 1e-9  # of the motion: what numbers are rounded by
MEDIAN_TO_STD = 1.4826
EVEN = 0.2  # of the usual time between samples


def between_counts(series: JointSeries, steps: Floats | None = None) -> JointSeries:
    """The same series with positions that move on between counts, at most half a count from the reading.

    ``steps`` (joints,): what ``counts`` says of it, where that is known.
    Each is from the longest window in which a parabola passes all readings within half a count, or within
    their noise where that is more than a count hides. Joints whose readings lie on no grid and have no noise,
    and stretches where samples are lost or come unevenly, stay as they are.
    """
    if len(series.stamp) < WINDOWS[-1]:
        return series
    steps = counts(series) if steps is None else steps
    noise = noises(series)
    steps = np.where(noise > HIDDEN * steps, REACH * noise, steps)
    if not any(steps):
        return series
    position, uneven = series.position.copy(), _uneven(series.stamp)
    for j, step in enumerate(steps):
        if step:
            readings = fill(series.position)[:, j]
            smooth = readings + step * _within(readings / step, uneven | np.isnan(position[:, j]))
            position[:, j] = np.where(np.isnan(position[:, j]), np.nan, smooth)
    return replace(series, position=position)


def counts(series: JointSeries) -> Floats:
    """(joints,) the step of each joint's encoder, 0 where its readings lie on no grid, and where a recording
    stops to measure: a grid is one that was asked for there.
    """
    if stops_to_measure(series.stamp):
        return np.zeros(len(series.joints))
    return np.array([count(column) for column in series.position.T])


def noises(series: JointSeries) -> Floats:
    """(joints,) standard deviation of what the readings of each joint scatter by where it moves least; 0
    where that goes on from sample to sample, as motion does, and where a recording stops to measure: what was
    asked for there is known exactly, however it scatters.
    """
    if len(series.stamp) < CALM or stops_to_measure(series.stamp):
        return np.zeros(len(series.joints))
    return np.array([scatter(readings) for readings in fill(series.position).T])


def scatter(readings: Floats) -> float:
    """That of one joint (n,)."""
    fourth = np.diff(readings, 4)
    signs = np.sign(fourth)
    if float(np.mean(signs[1:] * signs[:-1])) >= ALTERNATES:
        return 0.0
    blocks = np.array_split(np.abs(fourth), len(fourth) // CALM + 1)
    usual = np.array([np.median(block) for block in blocks]) * MEDIAN_TO_STD / np.sqrt(70.0)
    found = float(np.quantile(usual, CALMEST))
    return found if found > EXACT * float(np.ptp(readings)) else 0.0


def count(readings: Floats) -> float:
    """The step of the encoder that readings (n,) come from, in their unit; 0 where they lie on no grid."""
    known = readings[np.isfinite(readings)]
    places = np.unique(known)
    places = places[np.diff(places, prepend=-np.inf) > LEAST]
    if len(places) < 2:
        return 0.0
    smallest = float(np.diff(places).min())
    return _grid_of(known, places, smallest, 0.0) or _of_printed(known, places, smallest)


def _of_printed(known: Floats, places: Floats, smallest: float) -> float:
    """The step of the encoder whose readings (n,) were rounded once more, to a finer grid on which all lie,
    as numbers of a few decimals are; 0 where there is none.
    """
    unlike = np.diff(np.unique(np.diff(places)))
    finer = float(unlike[unlike > ON_GRID * smallest].min(initial=np.inf))
    printed = _grid_of(known, places, finer, 0.0) if len(places) >= MANY and np.isfinite(finer) else 0.0
    begun = smallest + printed * BEGUN if printed else ()
    return next((s for each in begun if (s := _grid_of(known, places, float(each), printed))), 0.0)


def _grid_of(known: Floats, places: Floats, step: float, printed: float) -> float:
    """The step of a grid on which readings (n,) lie, as near as they were ``printed``, at ``places`` (k,) of
    it; 0 where none is. ``step``: what it may be.
    """
    step = _refined(places, step)
    multiples = (known - known[0]) / step
    off = multiples - np.round(multiples)
    near = ON_GRID + printed / step / 2.0
    on_grid = bool((np.abs(off - np.median(off)) < near).all())  # the first one is rounded, too
    return step if on_grid and _rounded(np.round(multiples)) else 0.0


def _rounded(readings: Floats) -> bool:
    """Whether readings (n,), in counts, are an encoder's: their steps are of many kinds, or, of a joint too
    slow for that, change all the time.
    """
    moved = np.abs(np.diff(readings))
    if len(np.unique(moved)) >= KINDS:
        return True
    return len(np.unique(readings)) >= MANY and float(np.mean(np.diff(moved) != 0.0)) > VARIES


def _refined(places: Floats, step: float) -> float:
    """The step as distances between places (k,) tell it, the short ones first."""
    lags = 2 ** np.arange(int(np.log2(len(places))) + 1)
    apart = np.concatenate([places[lag:] - places[:-lag] for lag in lags])
    for reach in REACHES:
        whole = np.round(apart / step)
        near = (whole <= reach) & (whole != 0)
        if near.any():
            step = float(apart[near] @ whole[near] / (whole[near] @ whole[near]))
    return step


def _uneven(stamp: Floats) -> np.ndarray:
    """(n,): samples beside which others are missing."""
    between = np.diff(stamp)
    usual = float(np.median(between))
    odd = np.abs(between - usual) > EVEN * usual
    return np.append(odd, False) | np.insert(odd, 0, False)


def smoothed(readings: Floats, window: int) -> Floats:
    """Parabolas through each ``window`` of readings (n,), as scipy's ``savgol_filter``: importing that takes
    half a second of every command.
    """
    half = window // 2
    basis = np.vander(np.arange(window) - half, CURVED + 1).astype(np.float64)
    hat = basis @ np.linalg.pinv(basis)
    middle = np.convolve(readings, hat[half], mode="valid")
    return np.concatenate([hat[:half] @ readings[:window], middle, hat[half + 1 :] @ readings[-window:]])


def _within(readings: Floats, kept: np.ndarray) -> Floats:
    """What to add to readings (n,) in counts; 0 where they are ``kept``."""
    curve, fits = readings, ~kept
    for window in WINDOWS:
        tried = smoothed(readings, window)
        off = (np.abs(tried - readings) > NEAR) | kept
        fits = fits & ~maximum_filter1d(off, window)
        curve = np.where(fits, tried, curve)
    return np.clip(curve - readings, -0.5, 0.5)
