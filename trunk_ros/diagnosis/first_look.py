"""The first look at a stage: what its model knows, what its motion is like, how loud its sensors are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.bursts import bursts
from trunk_ros.data.louder import CONSTANT, Louder, growth
from trunk_ros.data.motion_content import is_wide, repeats, speed_tells
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.disturbances.knocks import with_knocks
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.stages.stage import Stage
from trunk_ros.levels import HALF
from trunk_ros.recording.signal.resample import SLOW


def first_look(stage: Stage) -> Context:
    """A stage as the model sees it, before anything is found."""
    blank = Context(stage, stage.views, ()).seen_with(stage.known)
    joints = blank.columns if stage.name == "wire" else ()  # all that drives do is lag
    loops = {c: _loop(blank, c) for c in joints}
    wide = frozenset(c for c, (is_always_alike, _) in loops.items() if is_always_alike)
    once = frozenset(c for c, (_, is_gone_through_once) in loops.items() if is_gone_through_once)
    first = replace(blank, wide=wide, once=once)
    return with_knocks(_with_bursts(replace(first, louder=_louder(first)).weighed(stage.known)))


def _with_bursts(context: Context) -> Context:
    """With the stretches in which most sensors are louder, of those whose noise is more than their steps; not
    where next to nothing of the motion was sampled, nor of drives.
    """
    if context.stage.name != "wire" or context.step >= SLOW:
        return context
    fine = [c for c in context.columns if context.stage.own_steps(c) < HALF * context.noise[c].std]
    rests = [context.evened(context.known, c) for c in fine]
    views = []
    for index, view in enumerate(context.views):
        valid = [view.columns[c].valid for c in fine]
        speeds = [column.speed for column in view.columns]
        found = bursts([rest[index] for rest in rests], valid, view.span.stamp, speeds)
        views.append(replace(view, span=replace(view.span, bursts=found)) if found else view)
    if not any(view.span.bursts for view in views):
        return context
    return replace(context, views=tuple(views)).weighed(context.known)


def _louder(context: Context) -> Louder:
    """How the noise grows with speed; not where next to nothing of the motion was sampled."""
    if context.step >= SLOW:
        return CONSTANT
    seen = [[view.columns[c] for view in context.views] for c in range(len(context.joints))]
    rests = [context.evened(context.known, c) for c in range(len(context.joints))]
    pairs = zip(rests, seen, strict=True)
    return Louder.of([growth(r, [s.speed for s in some], [s.valid for s in some]) for r, some in pairs])


def _loop(context: Context, column: int) -> tuple[bool, bool]:
    """Whether a column shows a wide loop and always moves alike, and whether it goes through none of it
    twice.
    """
    each = _motions(context, column)
    position, speed, rest, shown = map(np.concatenate, each)
    if not is_wide(position, rest, shown):
        return False, False
    alike = context.step < SLOW and not speed_tells(*each[:2])
    return alike, not repeats(position, speed)


def _motions(context: Context, column: int) -> list[tuple[Array, ...]]:
    """Gearbox angle, speed, what no effect explains and what was measured, (n,) of each recording where a
    column counts.
    """
    out = []
    for index, view in enumerate(context.views):
        now, valid = context.now(index, column), view.span.valid[:, column]
        rows = view.span.rows[valid]
        residual = context.residual(index, Hypothesis(), column)[valid]
        shown = view.span.target[valid, column]
        out.append((now.gearbox[rows, 0], now.speed[rows, 0], residual, shown))
    return list(zip(*out, strict=True))
