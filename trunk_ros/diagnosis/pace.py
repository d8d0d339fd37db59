"""The pace of two clocks that were found to differ, estimated with the physics: before that is known, what it
does to a joint hides how much of a lag is a clock's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis

SAME = 0.05  # of the standard deviation: a change of pace that is none


def paced(context: Context, hypothesis: Hypothesis) -> Context:
    """With each recording's clocks at the pace that is likeliest under a hypothesis and by what was found at
    first; as it is where they do not differ, or where it has them so already.
    """
    if context.stage.name != "wire" or not any(view.span.unsure for view in context.views):
        return context
    paces = [_likeliest(context, hypothesis, k) for k in range(len(context.views))]
    moved = [
        abs(pace - view.span.pace) > SAME * view.span.unsure
        for pace, view in zip(paces, context.views, strict=True)
    ]
    if not any(moved):
        return context
    views = []
    for k, (view, pace) in enumerate(zip(context.views, paces, strict=True)):
        late = np.column_stack([_late(context, k, c) for c in range(len(context.joints))])
        target = view.span.target + (pace - view.span.pace) * late
        views.append(replace(view, span=replace(view.span, target=target, pace=pace)))
    return replace(context, views=tuple(views), shown_before={}, _cache={})


def _likeliest(context: Context, hypothesis: Hypothesis, index: int) -> float:
    """s/s: least squares over all joints, held by the standard deviation of what was found."""
    span = context.views[index].span
    if span.unsure == 0.0:
        return 0.0
    along, square = 0.0, span.unsure**-2.0
    for column in context.columns:
        shapes = [np.zeros(len(view.span.rows)) for view in context.views]
        shapes[index] = _late(context, index, column)
        shape, rest = context.whiten_change(shapes, column), context.whitened(hypothesis, column)
        square += float(shape @ shape)
        along += float(shape @ (span.pace * shape - rest))
    return float(along / square)


def _late(context: Context, index: int, column: int) -> Array:
    """(n,) rad that a joint's reading changes per s/s of pace."""
    view = context.views[index]
    return np.asarray((view.span.stamp - view.span.stamp[0]) * view.columns[column].speed)
