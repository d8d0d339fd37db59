"""Samples in the place of lost ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from trunk_ros.levels import SURE
from trunk_ros.recording.recording import Floats, JointSeries
from trunk_ros.recording.signal.encoder import MEDIAN_TO_STD
from trunk_ros.recording.signal.fill import fill, hold
from trunk_ros.recording.signal.resample import SAME, longest_gap

GAP = 1.5  # usual times between samples
LONGEST = 600.0  # s that are filled at most, whoever asks: a grid never spans a hole
REGULAR = 0.7  # share of the samples that come in time where others may have been lost one by one
ALONE = 0.25  # share of what is missing that a step may be longer than one alone, and still be that one
STEADY = 0.9  # share of the samples that come in time where a topic is published at a rate


def usual(stamp: Floats) -> float:
    """Longest time [s] between two samples that shows no loss; infinite where samples come as they like."""
    between = np.diff(stamp)
    longest = _in_time(between)
    return longest if len(between) and float(np.mean(between <= longest)) >= REGULAR else np.inf


def _in_time(between: Floats) -> float:
    """Longest time [s], of those ``between`` (k,) samples, that is jitter and no wait for a lost one."""
    if len(between) < 3:
        return np.inf
    period = float(np.median(between))
    jitter = MEDIAN_TO_STD * float(np.median(np.abs(between - period)))
    return max(GAP * period, period + SURE * jitter)


def longest_wait(stamp: Floats) -> float:
    """Time [s] after which the next sample is late: some are lost, or none come for longer than is usual of
    those that come as they like.
    """
    return min(usual(stamp), longest_gap(stamp))


def runs(where: np.ndarray) -> np.ndarray:
    """(k, 2): the first row of each run of a mask (n,), and the one after its last."""
    return np.flatnonzero(np.diff(np.concatenate([[0], where.astype(int), [0]]))).reshape(-1, 2)


def gaps(stamp: Floats, longest: float = np.inf) -> np.ndarray:
    """(k,): samples after which others of a steady stream are missing, for at most ``longest`` s."""
    between = np.diff(stamp)
    wide = between > _in_time(between)
    steady = len(between) > 0 and float(np.mean(~wide)) >= STEADY
    return np.flatnonzero(wide & (between <= longest) & steady)


@dataclass(frozen=True)
class Late:
    """Samples ``after`` (k,) which the next comes late, as in ``gaps``: others are missing between, or their
    sender was ``held`` up (k,), as far as the course tells, and went on where it was.

    ``off`` (k, joints): how far the course may have been from what that says of it.
    """

    after: np.ndarray
    held: np.ndarray
    off: Floats


def late(series: JointSeries) -> Late:
    """What the steps before and after each gap say of the one over it: it is as long as they are where
    nothing is missing, and as many times as long as its time where others are.
    """
    between, steps = np.diff(series.stamp), np.diff(hold(series.position), axis=0)
    usual = float(np.median(between)) if len(between) else np.inf
    wide = between > _in_time(between)
    due = np.flatnonzero(~wide)
    after = np.flatnonzero(wide)
    if not len(due):
        return Late(after, np.zeros(len(after), dtype=bool), np.full((len(after), steps.shape[1]), np.inf))
    place = np.searchsorted(due, after)
    before, behind = (steps[due[np.clip(place + k, 0, len(due) - 1)]] for k in (-1, 0))
    usually, times = (before + behind) / 2.0, (between[after] / usual)[:, None]
    alone, among = np.abs(steps[after] - usually), np.abs(steps[after] - times * usually)
    more = np.abs((times - 1.0) * usually).sum(axis=1)
    held = alone.sum(axis=1) < ALONE * more
    bends = np.abs(before - behind) / 2.0
    off = np.where(held[:, None], alone + bends, among + times * bends)
    return Late(after, held, off)


def in_gaps(series: JointSeries, grid: Floats) -> np.ndarray:
    """(m, joints): where a value at ``grid`` (m,) s is guessed, since samples are missing, or none come for
    long.

    A guess is good to some part of the motion, not to the noise, which may be as small as it likes.
    """
    out = np.zeros((len(grid), len(series.joints)), dtype=bool)
    for j, lost in enumerate(unseen(series)):
        for begin, end in lost:
            first = np.searchsorted(grid, begin + SAME, side="right")
            out[first : np.searchsorted(grid, end - SAME), j] = True
    return out


def unseen(series: JointSeries) -> tuple[Floats, ...]:
    """Of each joint (k, 2) s between which its values are guessed in this way."""
    longest = longest_wait(series.stamp)
    known = [series.stamp[np.isfinite(position)] for position in series.position.T]
    last = [np.flatnonzero(np.diff(stamp) > longest) for stamp in known]
    return tuple(np.column_stack([s[k], s[k + 1]]) for s, k in zip(known, last, strict=True))


def missing(stamp: Floats, longest: float = np.inf, end: float = -np.inf) -> Floats:
    """(m,) s: when the samples missing in a stream's gaps, and from its last one to ``end`` s, had come."""
    usual = float(np.median(np.diff(stamp))) if len(stamp) > 1 else 1.0
    longest = min(longest, LONGEST)
    if GAP * usual < end - stamp[-1] <= longest:
        stamp = np.append(stamp, end + usual)
    parts = [
        np.linspace(stamp[k], stamp[k + 1], max(round((stamp[k + 1] - stamp[k]) / usual), 1) + 1)[1:-1]
        for k in gaps(stamp, longest)
    ]
    return np.concatenate([np.empty(0), *parts])


def bridged(series: JointSeries, guide: JointSeries | None = None, longest: float = np.inf) -> JointSeries:
    """The series with samples in its gaps of at most ``longest`` s.

    None where their sender was held up. They move as the guide does, which has the same joints, brought to
    what is known on both sides, and on to its end; without a guide smoothly, with the speeds of both sides.
    """
    added = missing(series.stamp, longest, -np.inf if guide is None else float(guide.stamp[-1]))
    seen = late(series)
    place = np.searchsorted(series.stamp, added) - 1
    added = added[~np.isin(place, seen.after[seen.held])]
    if not len(added):
        return series
    known = fill(series.position)
    values = _smooth(series.stamp, known, added) if guide is None else _led(series.stamp, known, added, guide)
    stamp = np.concatenate([series.stamp, added])
    order = np.argsort(stamp, kind="stable")
    stamp, position = stamp[order], np.concatenate([series.position, values])[order]
    new = (order >= len(series.stamp))[:, None]

    def with_gaps(given: Floats | None, instead: Floats) -> Floats | None:
        if given is None:
            return None
        return np.where(new, instead, np.concatenate([given, np.zeros_like(values)])[order])

    velocity = with_gaps(series.velocity, np.gradient(fill(position), stamp, axis=0))
    effort = with_gaps(series.effort, np.full_like(position, np.nan))
    return JointSeries(stamp, series.joints, position, velocity, effort)


def _smooth(stamp: Floats, known: Floats, at: Floats) -> Floats:
    before = np.searchsorted(stamp, at) - 1
    out = np.empty((len(at), known.shape[1]))
    for k in np.unique(before):
        slope = [_speed(stamp, known, k - 1, k), _speed(stamp, known, k + 1, k + 2)]
        curve = CubicHermiteSpline(stamp[[k, k + 1]], known[[k, k + 1]], np.array(slope))
        out[before == k] = curve(at[before == k])
    return out


def _speed(stamp: Floats, known: Floats, first: int, last: int) -> Floats:
    """(joints,) between two samples; 0 beyond the ends."""
    if first < 0 or last >= len(stamp):
        return np.zeros(known.shape[1])
    return np.asarray((known[last] - known[first]) / (stamp[last] - stamp[first]))


def _led(stamp: Floats, known: Floats, at: Floats, guide: JointSeries) -> Floats:
    shown = fill(guide.position)

    def led(times: Floats) -> Floats:
        return np.column_stack([np.interp(times, guide.stamp, column) for column in shown.T])

    off = known - led(stamp)
    return np.asarray(led(at) + np.column_stack([np.interp(at, stamp, column) for column in off.T]))
