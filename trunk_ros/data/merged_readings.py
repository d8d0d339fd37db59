"""Readings that come in messages, each with all joints, at whatever times: a logger writes a row with the
last of everything whenever one of its topics says something, so that the others are repeated in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.levels import CLEARLY, ENOUGH, NEARLY


def between_messages(stamp: Array, joints: Sequence[Array]) -> float:
    """Usual time [s] between the messages in which new readings (n,) of several joints come; 0 where they do
    not come in messages.

    While one joint moves, another one that moves as well has its new readings in the same rows, and none
    between these. Encoders of their own would count in any row, and so would a motion by fits and starts.
    """
    if len(joints) < 2:
        return 0.0
    changed = np.array([np.diff(column) != 0.0 for column in joints])
    apart = np.diff(stamp[1:][changed.any(axis=0)])
    usual = float(np.median(apart)) if len(apart) else 0.0
    if usual <= CLEARLY * float(np.median(np.diff(stamp))):
        return 0.0
    together = among = 0
    for one, other in permutations(changed, 2):
        lives = _lives(stamp[1:], one, 2.0 * usual)
        together += int(np.count_nonzero(one & other & lives))
        among += int(np.count_nonzero(other & lives))
    return usual if together > max(NEARLY * among, ENOUGH) else 0.0


def _lives(stamp: Array, changes: np.ndarray, longest: float) -> np.ndarray:
    """(n,) where a joint has had a new reading at most ``longest`` s ago, and has another as soon."""
    at = stamp[changes]
    if not len(at):
        return np.zeros(len(stamp), dtype=bool)
    after = np.searchsorted(at, stamp)
    waits = (
        at[np.minimum(after, len(at) - 1)] - at[np.maximum(np.searchsorted(at, stamp, side="right") - 1, 0)]
    )
    inside = (after < len(at)) & (stamp >= at[0])
    return np.asarray(inside & (waits <= longest))
