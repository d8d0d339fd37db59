"""Where a gap leaves it unknown how a joint sits within its backlash."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import STANDS, extent
from trunk_ros.levels import OUTLIERS
from trunk_ros.recording.signal.gaps import longest_wait
from trunk_ros.recording.signal.resample import SAME

FORGETS = 0.5  # s without gearbox angles in which a joint may have turned unseen


def forgotten(u: Array, grid: Array, stamp: Array, least: Array, small: Array, scatters: Array) -> np.ndarray:
    """(m, joints): where it is unknown how a joint sits within its backlash: after a gap in which it turned,
    or may have turned to and fro, until it has moved on. Turns by less than ``small`` (joints,) rad do not
    count, nor does what readings that scatter by ``scatters`` (joints,) rad seem to do.
    """
    out = np.zeros(u.shape, dtype=bool)
    for k in np.flatnonzero(np.diff(stamp) > longest_wait(stamp)):
        first = int(np.searchsorted(grid, stamp[k + 1] - SAME))
        unseen = (_turned_by(u, grid, stamp, int(k), scatters) > small) | bool(
            stamp[k + 1] - stamp[k] > FORGETS
        )
        if unseen.any():
            out[first:] |= (extent(u[first:]) < least) & unseen
    return out


def loop_of(u: Array, target: Array, valid: np.ndarray) -> Array:
    """(joints,) rad: half the width of what a line leaves of each joint's angle over its input, infinite
    where it does not move. Its play is no wider: what else is off, and noise, makes it more.
    """
    out = np.full(u.shape[1], np.inf)
    for j, seen in enumerate(valid.T):
        moved = u[seen, j] - np.mean(u[seen, j]) if seen.any() else np.empty(0)
        if len(moved) and np.ptp(moved) > STANDS:
            left = target[seen, j] - float(moved @ target[seen, j] / (moved @ moved)) * moved
            low, high = np.quantile(left, [OUTLIERS, 1.0 - OUTLIERS])
            out[j] = (high - low) / 2.0
    return out


def _turned_by(u: Array, grid: Array, stamp: Array, k: int, scatters: Array) -> Array:
    """(joints,) rad that each may have gone further in the gap after sample ``k`` before it turned, as a
    parabola turns; 0 where it goes on over the gap as it came, or went no further before and after than
    readings scatter.
    """
    at = stamp[[max(k - 1, 0), k, k + 1, min(k + 2, len(stamp) - 1)]]
    seen = u[np.clip(np.searchsorted(grid, at - SAME), 0, len(u) - 1)]
    steps, times = np.diff(seen, axis=0), np.maximum(np.diff(at), SAME)[:, None]
    before, over, after = steps / times
    turns = (before * over < 0) | (over * after < 0) | (before * after <= 0)
    surely = np.maximum(np.abs(steps) - scatters, 0.0) / times
    unseen = np.maximum(surely[0], surely[2]) * (at[2] - at[1]) / 4
    return np.asarray(np.where(turns, unseen, 0.0))
