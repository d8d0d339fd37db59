"""Moments at which the mean of a residual jumps."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array

SHORTEST = 5  # samples between two jumps


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


def _halved(sums: Array, first: int, last: int) -> tuple[float, int, int, int]:
    """Gain of the best cut between two samples, the first, the cut, and the last."""
    if last - first < 2 * SHORTEST:
        return 0.0, first, first, last
    cut = np.arange(first + SHORTEST, last - SHORTEST + 1)
    left, right = sums[cut] - sums[first], sums[last] - sums[cut]
    parts = left**2 / (cut - first) + right**2 / (last - cut)
    best = int(np.argmax(parts))
    whole = (sums[last] - sums[first]) ** 2 / (last - first)
    return float(parts[best] - whole), first, int(cut[best]), last
