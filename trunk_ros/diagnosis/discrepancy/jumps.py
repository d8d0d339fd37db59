"""Moments at which the mean of a residual jumps."""

from __future__ import annotations

import numpy as np
from scipy.special import bdtrc

from trunk_ros.compiled import Array, compiled
from trunk_ros.data.align import SETTLING
from trunk_ros.data.motion_content import APART
from trunk_ros.levels import CHANCE, HARDLY

TURNING = SETTLING  # s from a joint's turn within which a jump belongs to the turn


def jumps(stamp: Array, rest: Array, worth: float, most: int) -> Array:
    """(k,) s, in order: the moments at which a residual (n,) of unit noise jumps, found by halving it again
    and again where that explains most (Scott & Knott 1974, Biometrics 30(3)), down to a gain of ``worth``.
    """
    sums = np.concatenate([[0.0], np.cumsum(rest)])
    cuts: list[int] = []
    open_pieces = [_halved(sums, 0, len(rest))]
    while len(cuts) < most and open_pieces:
        gain, first, cut, last = open_pieces.pop(int(np.argmax([piece[0] for piece in open_pieces])))
        if gain < worth:
            break
        cuts.append(cut)
        open_pieces += [_halved(sums, first, cut), _halved(sums, cut, last)]
    at = np.array(sorted(cuts), dtype=int)
    return np.asarray(0.5 * (stamp[at - 1] + stamp[at]))


def moved_by(stamp: Array, rest: Array, moments: Array, angles: Array, column: int) -> bool:
    """Whether it is the motion that makes a residual (n,) of a joint's ``column`` jump, and not time: at that
    joint's turns, or as a joint of ``angles`` (n, joints) passes a place.
    """
    own = np.ascontiguousarray(angles[:, column])
    turns = stamp[turns_of(own, HARDLY * float(np.ptp(own)))]
    near = np.abs(np.subtract.outer(moments, turns)).min(axis=1, initial=np.inf) < TURNING
    usual = min(2.0 * TURNING * len(turns) / float(np.ptp(stamp)), 1.0)
    if bdtrc(near.sum() - 1, len(near), usual) < CHANCE:
        return True
    levels = np.array([part.mean() for part in np.split(rest, np.searchsorted(stamp, moments))])
    up = np.diff(levels) > 0.0
    at = angles[np.searchsorted(stamp, moments)]
    kinds = [at[some] for some in (up, ~up) if some.sum() > 1]
    if len(kinds) < 2:
        return False
    chance = np.prod([_within(_there(angles, kind), len(kind)) for kind in kinds], axis=0)
    return bool(chance.min() * len(chance) < CHANCE)


def _there(angles: Array, seen: Array) -> Array:
    """(joints,): the share of the time in which each joint is where it was ``seen`` (k, joints)."""
    place = seen.mean(axis=0)
    reach = np.maximum(np.abs(seen - place).max(axis=0), HARDLY * np.ptp(angles, axis=0))
    return np.asarray(np.mean(np.abs(angles - place) <= reach, axis=0))


def _within(share: Array, many: int) -> Array:
    """The chance that so ``many`` moments, each at any time, lie within a ``share`` of where a joint is: the
    range of as many (David and Nagaraja 2003, Order Statistics, 2.3).
    """
    return np.asarray(many * share ** (many - 1) - (many - 1) * share**many)


@compiled
def turns_of(x: Array, least: float) -> np.ndarray:
    """Rows at which a joint (n,) begins to come back, by ``least`` and more; where it stands at a turn, the
    last ones.
    """
    out = np.zeros(len(x), dtype=np.bool_)
    low = high = way = 0
    top = bottom = x[0] if len(x) else 0.0
    for k in range(len(x)):
        top, bottom = max(top, x[k]), min(bottom, x[k])
        high = k if x[k] > top - 0.1 * least else high
        low = k if x[k] < bottom + 0.1 * least else low
        if way >= 0 and top - x[k] > least:
            out[high] = way > 0
            way, low, bottom = -1, k, x[k]
        elif way <= 0 and x[k] - bottom > least:
            out[low] = way < 0
            way, high, top = 1, k, x[k]
    return np.flatnonzero(out)


def _halved(sums: Array, first: int, last: int) -> tuple[float, int, int, int]:
    """Gain of the best cut between two samples, the first, the cut, and the last."""
    if last - first < 2 * APART:
        return 0.0, first, first, last
    cut = np.arange(first + APART, last - APART + 1)
    left, right = sums[cut] - sums[first], sums[last] - sums[cut]
    parts = left**2 / (cut - first) + right**2 / (last - cut)
    best = int(np.argmax(parts))
    whole = (sums[last] - sums[first]) ** 2 / (last - first)
    return float(parts[best] - whole), first, int(cut[best]), last
