"""Joints that follow another joint's gearbox, and joints that turn against their own."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.pair import FOLLOWS, MixUp, Pair, correlation, own_correlation
from trunk_ros.data.motion_content import STILL
from trunk_ros.levels import SOME


def swapped(pair: Pair) -> list[MixUp]:
    """Joints that follow another joint's gearbox, and not their own."""
    alike = likeness(pair.driven, pair.target)
    rows, best = linear_sum_assignment(-alike)
    own, other = np.diag(alike), alike[rows, best]
    wrong = (best != rows) & (own < 1.0 - SOME) & (other > FOLLOWS)
    if not wrong.any():
        return []
    how = "; ".join(
        f"{pair.joints[i]} follows that of {pair.joints[best[i]]} (correlation {other[i]:.2f}, "
        f"{own[i]:.2f} with its own)"
        for i in np.flatnonzero(wrong)
    )
    source, target = pair.topics
    said = (
        f"{', '.join(pair.names(wrong))} look swapped: in {target}, compared with {source}, {how}. "
        "Correct the names in the driver, or the order of columns in the mapping, and diagnose again."
    )
    return [pair.found("order", wrong, said)]


def turned_signs(pair: Pair) -> list[MixUp]:
    """Joints that turn against what drives them; a remark where the model knows no ratio."""
    moved, turned = map(moves, (pair.target, pair.driven))
    sign = np.where(moved & turned, own_correlation(pair), 0.0)
    against, along = sign < -FOLLOWS, sign > FOLLOWS
    if not against.any() or not (pair.ratio_known or along.any()):
        return []
    source, target = pair.topics
    said = f"{', '.join(pair.names(against))}: {target} runs against {source}"
    if not pair.ratio_known:
        return [pair.found("sign", against, f"{said}, where other joints run along with it", certain=False)]
    ratio = " Turn the sign of wire.ratio in the model, or of the readings," if pair.stage == "wire" else ""
    to_do = ratio or " Turn the sign of one of the two"
    said = f"{said}, where the model has both turn the same way: a sign is turned.{to_do} and diagnose again."
    return [pair.found("sign", against, said)]


def likeness(driven: Array, shown: Array) -> Array:
    """(joints, joints) |correlation| of each reading (row) with what turns each joint (column); what stands
    is like what stands.
    """
    out = np.zeros((shown.shape[1], driven.shape[1]))
    moved, turned = map(moves, (shown, driven))
    for i, reading in enumerate(shown.T):
        for j, drive in enumerate(driven.T):
            both = moved[i] and turned[j]
            out[i, j] = abs(correlation(reading, drive)) if both else float(moved[i] == turned[j])
    return out


def moves(angles: Array) -> np.ndarray:
    """(joints,) whether each of them (n, joints) moves, beside the one that moves most."""
    span = np.ptp(angles, axis=0)
    return np.asarray(span > STILL * span.max())
