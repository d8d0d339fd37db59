"""Topics of different rates and phases on one time grid."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from trunk_ros.errors import RecordingError
from trunk_ros.recording.recording import Floats, JointSeries
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.through_readings import slopes

FINE = 0.0125  # s: a moving arm is computed at least this often
SLOW = 0.2  # s: recordings slower than this stop and measure; nothing is known of what lies between
SAME = 1e-6  # s: stamps closer than this are one
PAIRED = 4.0  # rows of a grid to each stop, from which on another topic goes on between them
LONGEST_GAP = 0.12  # s without a sample after which the comparison pauses


def joint_grid(
    driving: Floats, measured: Floats, fine: bool = True, beyond: bool = False
) -> tuple[Floats, np.ndarray, np.ndarray]:
    """(grid, rows, kept): a grid over both stamps, the grid's rows at the measured stamps that are ``kept``.

    ``beyond``: keep stamps outside the driving ones as well.
    """
    kept = (measured >= driving[0] - SAME) & (measured <= driving[-1] + SAME)
    if not kept.any():
        raise RecordingError("the topics do not overlap in time: check that their stamps come from one clock")
    kept |= beyond
    both = np.union1d(driving, measured[kept])
    grid = both[np.concatenate([[True], np.diff(both) > SAME])]
    step = float(np.median(np.diff(grid))) if len(grid) > 1 else FINE
    if fine and FINE < step < SLOW:
        grid = _subdivided(grid)
    rows = np.clip(np.searchsorted(grid, measured[kept] - SAME), 0, len(grid) - 1)
    return grid, rows, kept


def _subdivided(grid: Floats) -> Floats:
    gaps = np.diff(grid)
    parts = np.where(gaps < SLOW * 2, np.ceil(gaps / FINE), 1).astype(int)
    starts = np.repeat(grid[:-1], parts)
    share = np.concatenate([np.arange(p) / p for p in parts])
    return np.append(starts + share * np.repeat(gaps, parts), grid[-1])


def stops_to_measure(stamp: Floats) -> bool:
    """Whether a recording is so slow that nothing is known of what lies between two samples: then a sample
    is what was asked for and reached, no noisy reading of a motion.
    """
    return len(stamp) > 1 and float(np.median(np.diff(stamp))) > SLOW


def resample(series: JointSeries, grid: Floats) -> tuple[Floats, Floats]:
    """Position and velocity (m, joints) on the grid; by the measured velocity where there is one that
    fits. Where a recording stops to measure, what was read next to a time is of the same stop, whatever
    topic came first; where the other topic goes on meanwhile, each sample holds until the next.
    """
    t, position = series.stamp, fill(series.position)
    if len(t) == len(grid) and np.allclose(t, grid, rtol=0, atol=SAME):
        return position, _velocity(series, position)
    inside = np.clip(grid, t[0], t[-1])
    beyond = np.clip(grid - inside, *_one_step(t))[:, None]
    if stops_to_measure(t):
        at_rest = position[_nearest(t, grid) if len(grid) < PAIRED * len(t) else _last(t, grid)]
        return at_rest, _slope(grid, at_rest)
    if len(t) < 4:
        curve = PchipInterpolator(t, position) if len(t) > 1 else None
        values = np.repeat(position, len(grid), axis=0) if curve is None else curve(inside)
        return values, _slope(grid, values)
    measured = fill(np.asarray(series.velocity)).T if _fits(series, position) else None
    values, slope = _hermite(t, position, measured, inside)
    for after, before in wide_gaps(t):
        guessed = (inside > t[after]) & (inside < t[before])
        step = (position[before] - position[after]) / (t[before] - t[after])
        values[guessed] = position[after] + (inside[guessed] - t[after])[:, None] * step
        slope[guessed] = step
    return values + beyond * slope, slope


def _hermite(t: Floats, position: Floats, velocity: Floats | None, at: Floats) -> tuple[Floats, Floats]:
    """(m, joints) and its slope at times (m,), joint by joint: the curves take six times the memory of what
    they go through. ``velocity``: (joints, n), where it was measured.
    """
    values, slope = np.empty((2, len(at), position.shape[1]))
    for j, column in enumerate(position.T):
        spline = CubicHermiteSpline(t, column, slopes(t, column, None if velocity is None else velocity[j]))
        values[:, j], slope[:, j] = spline(at), spline(at, 1)
    return values, slope


def _last(stamp: Floats, grid: Floats) -> np.ndarray:
    """(m,) which of the stamps (n,) came last at each of the grid."""
    return np.clip(np.searchsorted(stamp, grid + SAME, side="right") - 1, 0, None)


def _nearest(stamp: Floats, grid: Floats) -> np.ndarray:
    """(m,) which of the stamps (n,) is next to each of the grid."""
    after = np.clip(np.searchsorted(stamp, grid), 1, len(stamp) - 1)
    return np.where(grid - stamp[after - 1] <= stamp[after] - grid, after - 1, after)


def _one_step(stamp: Floats) -> tuple[float, float]:
    """How far before and after its samples a motion may be taken to go on [s]."""
    step = float(np.median(np.diff(stamp)))
    return -step, step


def wide_gaps(stamp: Floats) -> list[tuple[int, int]]:
    """Samples on both sides of gaps too long to be bridged by a curve: it would swing far out in them."""
    usual = longest_gap(stamp)
    return [(int(k), int(k) + 1) for k in np.flatnonzero(np.diff(stamp) > usual)]


def longest_gap(stamp: Floats) -> float:
    """Time without a sample [s] that can still be bridged."""
    return max(LONGEST_GAP, 4.0 * float(np.median(np.diff(stamp)))) if len(stamp) > 1 else LONGEST_GAP


def _velocity(series: JointSeries, position: Floats) -> Floats:
    if _fits(series, position):
        return fill(np.asarray(series.velocity))
    return _slope(series.stamp, position)


def _slope(stamp: Floats, position: Floats) -> Floats:
    if len(stamp) <= 2:
        return np.zeros_like(position)
    return np.column_stack([np.gradient(column, stamp) for column in position.T])


def _fits(series: JointSeries, position: Floats) -> bool:
    """Whether the recorded velocity is that of the recorded position."""
    if series.velocity is None or not np.isfinite(series.velocity).any() or len(position) < 5:
        return False
    slope = _slope(series.stamp, position)
    size = float(np.sqrt(np.mean(slope**2)))
    slope -= fill(series.velocity)
    off = float(np.sqrt(np.mean(np.square(slope, out=slope))))
    return off < 0.5 * size + 1e-9
