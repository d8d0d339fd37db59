"""What a residual says of its noise where a recording comes to the same places again: stations that are far
apart tell nothing of it from one to the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from trunk_ros.compiled import Array
from trunk_ros.data.noise import BINOMIAL, trimmed


def neighbours(places: Array) -> np.ndarray:
    """(n,) the row nearest to each of some places (n, joints) so many rows away that it does not show in
    fourth differences; the row itself where there is none near by. Each joint counts by how far it goes.
    """
    away = len(BINOMIAL) - 1
    size, many = np.std(places, axis=0), min(2 * away + 1, len(places))
    moves = size > 0.0
    itself = np.arange(len(places))
    if many < 2 or not moves.any():
        return itself
    scaled = places[:, moves] / size[moves]
    near = cKDTree(scaled).query(scaled, many)[1]
    elsewhere = np.abs(near - itself[:, None]) >= away
    first = near[itself, elsewhere.argmax(axis=1)]
    return np.where(elsewhere.any(axis=1), first, itself)


def between_visits(residuals: list[Array], masks: list[np.ndarray], nearest: Sequence[np.ndarray]) -> float:
    """Standard deviation of a signal's noise, by the residuals (n,) of each recording at places and at those
    ``nearest`` to them (n,), where both count (n,): the delta test, which is too large by what goes with the
    place or with how it was reached; infinite where nothing is.
    """
    apart = [np.empty(0)]
    for rest, mask, near in zip(residuals, masks, nearest, strict=True):
        both = mask & mask[near] & (near != np.arange(len(rest)))
        apart.append(np.abs(rest[both] - rest[near[both]]) / np.sqrt(2.0))
    size = np.concatenate(apart)
    return trimmed(size) if size.size else np.inf
