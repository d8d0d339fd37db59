"""How far the clocks of two topics are apart, where that is more than any sensor is late."""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from trunk_ros.chain import REMEMBERED
from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.order import moves
from trunk_ros.data.mix_ups.pair import FOLLOWS, correlation
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.levels import FEWEST, PART, SOME
from trunk_ros.machine import CELLS
from trunk_ros.recording.signal.fill import fill

COARSE = 0.05  # s: as exactly as it is needed
BANDS = np.linspace(0.02, 0.48, 16)  # half-widths of dead bands, of the motion


def clock_offset(first: Array, source: Array, second: Array, target: Array) -> float:
    """Seconds by which ``target`` (m, joints) at stamps ``second`` (m,) is later than ``source`` (n, joints)
    at ``first`` (n,); 0 where it fits as it is, or where no shift makes it fit, or where no joint turns back:
    one way a curve does the same.
    """
    if min(len(first), len(second)) < FEWEST or _alike(first, source, second, target) > FOLLOWS:
        return 0.0
    drives = fill(source)
    if not any(map(_turns_back, drives[:, moves(drives)].T)):
        return 0.0
    usual = max(float(np.median(np.diff(stamp))) for stamp in (first, second))
    step = max(COARSE, usual, np.ptp(first) / CELLS, np.ptp(second) / CELLS)
    lag = _lag(_changes(first, source, step), _changes(second, target, step))
    off = float(second[0] - first[0]) + step * lag
    if abs(off) <= REMEMBERED:  # it is a delay
        return 0.0
    least = max(FOLLOWS, _alike_by_a_play(first, source, second, target))
    return off if _alike(first + off, source, second, target) > least else 0.0


def _turns_back(path: Array) -> bool:
    """Whether (n,) of a joint goes back by more than a small part of its way."""
    down, up = np.maximum.accumulate(path) - path, path - np.minimum.accumulate(path)
    return bool(min(down.max(), up.max()) > PART * np.ptp(path))


def _alike_by_a_play(first: Array, source: Array, second: Array, target: Array) -> float:
    """The same as the clocks are, behind the best dead band, at whose one side or the other a joint may lie
    at first: in a steady swing it comes late as well.
    """
    drives, bands = fill(source), np.outer(BANDS, np.ptp(fill(source), axis=0))
    sides = [(band, drives[0] + side * band) for band in bands for side in (-1.0, 0.0, 1.0)]
    played = [SharpPlay().run(drives, band[None], begun)[0] for band, begun in sides]
    return max(_alike(first, each, second, target) for each in played)


def _changes(stamp: Array, values: Array, step: float) -> Array:
    """(k, joints) from one even step to the next, each joint's of the same power."""
    grid = np.arange(stamp[0], stamp[-1] + step / 2, step)
    moved = np.column_stack([np.interp(grid, stamp, column) for column in fill(values).T])
    changes = np.diff(moved, axis=0)
    size = np.sqrt(np.mean(changes**2, axis=0))
    return np.asarray(changes / np.where(size > 0.0, size, np.inf))


def _lag(source: Array, target: Array) -> int:
    """Steps by which the target is later than the source, counted from the beginning of each."""
    length = next_fast_len(len(source) + len(target))
    spectrum = np.conj(rfft(source, length, axis=0)) * rfft(target, length, axis=0)
    alike = np.abs(irfft(spectrum, length, axis=0)).sum(axis=1)
    lags = np.arange(length)
    lags = np.where(lags < len(target), lags, lags - length)
    overlap = np.minimum(len(source), len(target) - lags) - np.maximum(0, -lags)
    enough = overlap >= SOME * min(len(source), len(target))
    return int(lags[np.argmax(np.where(enough, alike, 0.0))])


def _alike(first: Array, source: Array, second: Array, target: Array) -> float:
    """Median |correlation| of the joints that move while both were recorded; 0 where that is too short."""
    both = (second >= first[0]) & (second <= first[-1])
    if both.sum() < SOME * len(second):
        return 0.0
    drives = [np.interp(second[both], first, column) for column in fill(source).T]
    pairs = list(zip(drives, fill(target)[both].T, strict=True))
    found = [abs(correlation(a, b)) for a, b in pairs if np.ptp(a) > 0.0 and np.ptp(b) > 0.0]
    return float(np.median(found)) if found else 1.0
