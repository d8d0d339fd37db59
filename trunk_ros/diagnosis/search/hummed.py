"""Tones that all joints share and that show only beside the physics: before that is known, what the motion
may say of a joint hides what is as slow as the motion, or comes back a few times only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.sensing.hum import TONES, Hum, tone
from trunk_ros.data.sensing.physics import CLOCKED
from trunk_ros.data.surroundings import View
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import kinds_of_all, open_kinds
from trunk_ros.diagnosis.search.fit import Fit, costed, refit
from trunk_ros.diagnosis.search.formed import measured
from trunk_ros.diagnosis.search.residuals import Residuals
from trunk_ros.diagnosis.search.screen import Kept, Screen
from trunk_ros.diagnosis.search.trial import looks, on_all_joints
from trunk_ros.levels import JOINTS, SEVERAL
from trunk_ros.machine import precision
from trunk_ros.recording.signal.resample import SLOW


def told_from_hum(now: Fit, kept: Callable[[int], Kept]) -> Fit:
    """Without tones of one size on all joints in what a hypothesis leaves, once no further effect may explain
    more there than they do. ``kept``: looks at a column.
    """
    context = now.context
    if context.stage.name != "wire" or context.step > SLOW / 2 or len(context.columns) < JOINTS:
        return now
    views = []
    for index, view in enumerate(context.views):
        found = _tone(context, now.hypothesis, index) if len(view.hums) < TONES else None
        views.append(view if found is None else _without(view, context.columns, found))
    if all(new is old for new, old in zip(views, context.views, strict=True)):
        return now
    still = context.viewing(views, anew=True).weighed(now.hypothesis)
    gained = now.total - costed(still.in_noise(context.noise), now.hypothesis).total
    if _may_be_named(now, kept, gained):
        return now
    return refit(measured(costed(still, context.known)), now.hypothesis)


def _may_be_named(now: Fit, kept: Callable[[int], Kept], gained: float) -> bool:
    """Whether an effect of all joints, or one on each of them, explains by a linear look more than tones have
    ``gained``: a slow course that joints have in common is as long as that is missing no tone for sure.
    """
    context, hypothesis = now.context, now.hypothesis

    def alone(column: int) -> float:
        kinds = open_kinds(context, hypothesis, column)
        found = looks(context, hypothesis, column, kinds, kept=kept(column))
        return max((look.gain for look in found), default=0.0)

    together = on_all_joints(Screen(context, hypothesis), kinds_of_all(context, hypothesis))
    most = [sum(map(alone, context.columns)), *(candidate.gain for candidate in together)]
    return max(most) > gained


def _tone(context: Context, hypothesis: Hypothesis, index: int) -> Hum | None:
    """The strongest tone of all joints that can be judged in what is left of a span, beside what the values
    of a hypothesis do: they were fitted while the tone was there.
    """
    span, columns = context.views[index].span, context.columns
    rows = np.asarray(span.valid[:, columns].all(axis=1))
    if np.count_nonzero(rows) < CLOCKED:
        return None
    off = (context.residual(index, hypothesis, c)[rows] for c in columns)
    asked = (span.measured(span.gearbox[:, c])[rows] * context.arm.ratio[c] for c in columns)

    def followed(joint: int) -> Array:
        return _followed(context, hypothesis, index, columns[joint], rows)

    return tone(span.stamp[rows], off, asked, followed, SEVERAL)


def _followed(context: Context, hypothesis: Hypothesis, index: int, column: int, rows: np.ndarray) -> Array:
    """(k, 1 + values): of some ``rows`` (n,) a constant, and what is left of a column by small steps of the
    values that move it.
    """
    values = Residuals(context, hypothesis, context.columns)
    x = hypothesis.free_values(values.free)
    there, moving = x + values.steps(x), values.moving(column)
    base, count = context.residual(index, hypothesis, column)[rows], 1
    out = np.ones((len(base), 1 + len(moving)), precision(len(base)), "F")
    for k in moving:
        moved = context.residual(index, hypothesis.moved(values.free[k], there[k]), column)[rows]
        if np.isfinite(moved).all():
            out[:, count] = moved - base
            count += 1
    return out[:, :count]


def _without(view: View, columns: list[int], found: Hum) -> View:
    """With readings of some columns without a tone."""
    target: Array = view.span.target.copy()
    target[:, columns] -= found.at(view.span.stamp)
    return replace(view, span=replace(view.span, target=target), hums=(*view.hums, (tuple(columns), found)))
