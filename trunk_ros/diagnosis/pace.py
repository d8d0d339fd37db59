"""Two clocks that differ, or may, in pace or by a constant, estimated with the physics: before that is known,
what it does to a joint hides how much of a lag is a clock's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.noise import FLOOR
from trunk_ros.data.sensing.pairs import told
from trunk_ros.data.sensing.physics import gains
from trunk_ros.data.sensing.skew import LARGEST, unseen_skew
from trunk_ros.data.span import Span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.effects.curve import abscissa
from trunk_ros.guards import SAME
from trunk_ros.levels import HARDLY, SCATTER, SURE
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import TOPICS


def with_its_clocks(span: Span, recording: Recording, model: ArmModel) -> Span:
    """A span of gearbox and joints, with how much of a skew it may hide where stamps are of two clocks."""
    if span.unsure[0] > 0.0:
        return span
    gearbox, shown = (recording.require(k).select(span.joints) for k in ("gearbox_states", "joint_states"))
    arm = model.for_joints(span.joints).loaded_arm().only(span.joints)
    return replace(span, unseen=unseen_skew(gearbox, shown, arm))


def with_unseen_skew(context: Context, hypothesis: Hypothesis) -> Context | None:
    """With the skew that two clocks may have which did not show one at first; None where none may have."""
    spans = [view.span for view in context.views]
    if not any(span.unseen for span in spans) or any(span.unsure[0] for span in spans):
        return None
    known = [replace(span, unsure=(span.unseen, span.unsure[1])) for span in spans]
    views = [replace(view, span=span) for view, span in zip(context.views, known, strict=True)]
    return paced(context.viewing(views), hypothesis)


def paced(context: Context, hypothesis: Hypothesis) -> Context:
    """With each recording's clocks as is likeliest under a hypothesis and by what was found at first; as it
    is where they do not differ, or where it has them so already, within what is known of them.
    """
    if context.stage.name != "wire" or not any(any(view.span.unsure) for view in context.views):
        return context
    paces = [_likeliest(context, hypothesis, k) for k in range(len(context.views))]
    moved = [
        np.abs(pace - view.span.pace) > np.maximum(std, HARDLY * np.array(view.span.unsure))
        for (pace, std), view in zip(paces, context.views, strict=True)
    ]
    if not np.any(moved):
        return context
    views = []
    for k, (view, (pace, _)) in enumerate(zip(context.views, paces, strict=True)):
        further = pace - view.span.pace
        late = [_late(context, hypothesis, k, c) @ further for c in range(len(context.joints))]
        target = view.span.target + np.column_stack(late)
        views.append(replace(view, span=replace(view.span, target=target, pace=tuple(pace))))
    return context.viewing(views, anew=True)


def differ(context: Context, hypothesis: Hypothesis) -> bool:
    """Whether a recording's clocks go at different paces for sure."""
    found = [_likeliest(context, hypothesis, k) for k in range(len(context.views))]
    return any(SURE * SCATTER * std[0] < abs(pace[0]) < LARGEST for pace, std in found)


def skew_told(context: Context, hypothesis: Hypothesis, index: int) -> Iterator[Observed]:
    """What to say of the clocks of a recording where a skew showed beside the physics alone."""
    span = context.views[index].span
    if not span.unseen or not span.unsure[0]:
        return
    (rate, _), (std, _) = (1e6 * each for each in _likeliest(context, hypothesis, index))
    rate, std = float(rate), SCATTER * float(std)
    if abs(rate) <= SURE * std:
        return
    first, second = TOPICS["joint_states"], TOPICS["gearbox_states"]
    said = (
        f"the clock of {first} runs {abs(rate):.0f} ± {std:.1f} ppm {'fast' if rate > 0.0 else 'slow'} "
        f"beside that of {second}: this showed together with the physics, and was taken off with it"
    )
    yield told("skew", (first, span.joints), rate, std, "ppm", said, "Synchronise the clocks (chrony, PTP)")


def _likeliest(context: Context, hypothesis: Hypothesis, index: int) -> tuple[Array, Array]:
    """(2,) s/s and s: least squares over all joints, held by the standard deviations of what was found; and
    the std of each. What a joint is late by for sure beside a hypothesis, such as a lag that has no name as
    yet, is no pace.
    """
    span = context.views[index].span
    unsure, pace = np.array(span.unsure), np.array(span.pace)
    if not unsure.any():
        return pace, unsure
    columns = context.columns
    square, along = np.diag([1.0, 1.0, *np.full(len(columns), SAME)]), np.zeros(2 + len(columns))
    for k, column in enumerate(columns, start=2):
        rest, late = context.whitened(hypothesis, column), _late(context, hypothesis, index, column)
        grows, ahead = (_whitened(context, index, each, column) for each in late.T)
        own = ahead / max(float(np.linalg.norm(ahead)), FLOOR)
        shape = np.column_stack([grows * unsure[0], ahead * unsure[1], own])  # in standard deviations
        at = [0, 1, k]
        square[np.ix_(at, at)] += shape.T @ shape
        along[at] += shape.T @ (shape[:, :2] @ (pace / np.where(unsure > 0.0, unsure, 1.0)) - rest)
    known = np.linalg.inv(square)
    sure = np.abs(known @ along) > SURE * np.sqrt(known.diagonal())
    keep = np.flatnonzero([True, True, *sure[2:]])
    known = np.linalg.inv(square[np.ix_(keep, keep)])
    return unsure * (known @ along[keep])[:2], unsure * np.sqrt(known.diagonal()[:2])


def _whitened(context: Context, index: int, change: Array, column: int) -> Array:
    """A change (n,) of a column in one recording, as unit noise over all of them."""
    each = [np.zeros(len(view.span.rows)) for view in context.views]
    each[index] = change
    return context.whiten_change(each, column)


def _late(context: Context, hypothesis: Hypothesis, index: int, column: int) -> Array:
    """(n, 2) rad that a joint's reading changes per s/s of pace and per s ahead."""
    view = context.views[index]
    since = view.span.stamp - view.span.stamp[0]
    asked = view.span.measured(abscissa("position", context.now(index, column), 0))
    turned = gains(asked[:, None], context.predictions(hypothesis, column)[index][:, None])
    speed = view.columns[column].speed * turned
    return np.asarray(np.column_stack([since, np.ones_like(since)]) * speed[:, None])
