"""Two clocks that were found to differ, in pace or by a constant, estimated with the physics: before that is
known, what it does to a joint hides how much of a lag is a clock's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import SLIGHT


def paced(context: Context, hypothesis: Hypothesis) -> Context:
    """With each recording's clocks as is likeliest under a hypothesis and by what was found at first; as it
    is where they do not differ, or where it has them so already.
    """
    if context.stage.name != "wire" or not any(any(view.span.unsure) for view in context.views):
        return context
    paces = [_likeliest(context, hypothesis, k) for k in range(len(context.views))]
    moved = [
        np.abs(pace - view.span.pace) > SLIGHT * np.array(view.span.unsure)
        for pace, view in zip(paces, context.views, strict=True)
    ]
    if not np.any(moved):
        return context
    views = []
    for k, (view, pace) in enumerate(zip(context.views, paces, strict=True)):
        late = [_late(context, k, c) @ (pace - view.span.pace) for c in range(len(context.joints))]
        target = view.span.target + np.column_stack(late)
        views.append(replace(view, span=replace(view.span, target=target, pace=tuple(pace))))
    return replace(context, views=tuple(views), shown_before={}, _cache={})


def _likeliest(context: Context, hypothesis: Hypothesis, index: int) -> Array:
    """(2,) s/s and s: least squares over all joints, held by the standard deviations of what was found."""
    span = context.views[index].span
    unsure, pace = np.array(span.unsure), np.array(span.pace)
    if not unsure.any():
        return pace
    along, square = np.zeros(2), np.eye(2)
    for column in context.columns:
        rest, shapes = context.whitened(hypothesis, column), []
        for late in (_late(context, index, column) * unsure).T:  # in standard deviations
            each = [np.zeros(len(view.span.rows)) for view in context.views]
            each[index] = late
            shapes.append(context.whiten_change(each, column))
        shape = np.column_stack(shapes)
        square += shape.T @ shape
        along += shape.T @ (shape @ (pace / np.where(unsure > 0.0, unsure, 1.0)) - rest)
    return np.asarray(unsure * np.linalg.solve(square, along))


def _late(context: Context, index: int, column: int) -> Array:
    """(n, 2) rad that a joint's reading changes per s/s of pace and per s ahead."""
    view = context.views[index]
    since = view.span.stamp - view.span.stamp[0]
    return np.asarray(np.column_stack([since, np.ones_like(since)]) * view.columns[column].speed[:, None])
