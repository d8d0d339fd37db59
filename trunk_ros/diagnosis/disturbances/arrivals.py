"""How drives arrive where a recording stops to measure: one that goes beyond and comes back takes the wires
back with it, which makes every dead band look narrower. No sample shows it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from trunk_ros.compiled import Array
from trunk_ros.data.surroundings import View
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.levels import NOTABLE, PART

NEAREST = 1e-5


def stops(context: Context) -> bool:
    """Whether drives were only seen where they stopped."""
    return any(len(view.span.arrives) for view in context.views)


def arrived(context: Context, hypothesis: Hypothesis) -> Context:
    """With each joint's drive going as far beyond its stops as makes what was measured likeliest under a
    hypothesis; as it is where samples follow the motion, or where it has them so already.
    """
    if not stops(context):
        return context
    beyond = np.zeros(len(context.joints))
    for column in context.columns:
        beyond[column] = _likeliest(context, hypothesis, column)
    views = [_arriving(view, beyond) for view in context.views]
    pairs = zip(views, context.views, strict=True)
    if all(np.abs(new.wires - old.wires).max() <= NEAREST * np.ptp(old.wires) for new, old in pairs):
        return context
    return _with(context, beyond)


def _likeliest(context: Context, hypothesis: Hypothesis, column: int) -> float:
    """Part of each way that a joint's drive goes beyond its end; none where that is no more than chance, or
    where the likeliest is further than any drive goes.
    """

    def left(beyond: float) -> float:
        there = _with(context, beyond * (np.arange(len(context.joints)) == column))
        rest = there.whitened(hypothesis, column)
        return float(rest @ rest)

    tried = np.concatenate([[0.0], np.geomspace(NEAREST, PART, 14)])  # beyond, it is no drive that settles
    costs = [left(beyond) for beyond in tried]
    best = int(np.argmin(costs))
    if best in (0, len(tried) - 1):
        return 0.0
    near = float(tried[best - 1]), float(tried[best + 1])
    found = minimize_scalar(left, bounds=near, method="bounded", options={"xatol": NEAREST})
    return float(found.x) if found.fun < costs[0] - NOTABLE**2 else 0.0


def _with(context: Context, beyond: Array) -> Context:
    return context.viewing([_arriving(view, beyond) for view in context.views])


def _arriving(view: View, beyond: Array) -> View:
    """With drives that first go ``beyond`` (joints,) of each way, and come back from there."""
    span, path, here = view.span, view.span.gearbox.copy(), view.span.arrives
    path[here] = path[here + 1] + beyond * (path[here + 1] - path[here - 1])
    return replace(view, span=replace(span, source=path, gearbox=path), told=view.angles, posture=view.angles)
