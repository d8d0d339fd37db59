"""Where a joint at rest is knocked: what its neighbours do shakes it elsewhere within its dead band, and it
lies there until its own motor moves it on. That says where it happened to lie, and nothing of its wire.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.sensing.pairs import told
from trunk_ros.diagnosis.data.surroundings import View
from trunk_ros.diagnosis.discrepancy.jumps import jumps
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import ENOUGH, FEWEST, PART, SURE, THREEFOLD
from trunk_ros.diagnosis.search.score import SIGNIFICANT, chance
from trunk_ros.diagnosis.thrown import goes_on, throws
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.topics import TOPICS

BRIEF = 8  # samples: a knock is over in fewer, and at least twice as many tell what is on each side


def told_from_knocks(context: Context) -> Context:
    """With the moments at which joints that rest are knocked within their dead bands."""
    if context.stage.name != "wire":
        return context
    views = tuple(_knocked(context, index, view) for index, view in enumerate(context.views))
    if all(new is old for new, old in zip(views, context.views, strict=True)):
        return context
    return replace(context, views=views, shown_before={}, _cache={}).weighed(context.known)


def knocks_told(context: Context, hypothesis: Hypothesis, index: int) -> Observed | None:
    """What to say of the knocks in a recording that are none of what a hypothesis says happened."""
    view, far = context.views[index], dict[int, list[float]]()
    for c in sorted({c for c, _ in view.span.knocks}):
        predicted = context.stage.predict(context, index, hypothesis, c)
        moved = (abs(far) for far, _ in throws(view, hypothesis, c, predicted))
        far[c] = [one for one in moved if one > context.noise[c].std]
    most = max((max(each) for each in far.values() if each), default=0.0)
    if not most:
        return None
    joints = tuple(context.joints[c] for c, each in far.items() if each)
    said = (
        f"{', '.join(joints)}: shaken elsewhere within the dead band while at rest, by what moved beside it, "
        f"{sum(map(len, far.values()))} times, by up to {1e3 * most:.2g} mrad. Where a joint lies in it says "
        "nothing of its wire, and was fitted"
    )
    return told("knocks", (TOPICS["joint_states"], joints), most, None, "rad", said)


def _knocked(context: Context, index: int, view: View) -> View:
    banded = [c for c in context.columns if view.arm.dead_band[c] > 0.0]
    found = tuple((c, at) for c in banded for at in _knocks(context, index, c))
    return replace(view, span=replace(view.span, knocks=found)) if found else view


def _knocks(context: Context, index: int, column: int) -> Iterator[float]:
    """The moments [s] at which a joint is knocked in a span."""
    view, noise = context.views[index], context.noise[column].std
    span, worth = view.span, SIGNIFICANT * chance(context, column)
    ratio, least = float(view.arm.ratio[column]), PART * float(view.arm.dead_band[column])
    off = context.residual(index, context.known, column)
    for first, last in rests(view.span.gearbox[:, column], span.rows, ratio, least):
        rows = first + np.flatnonzero(span.valid[first:last, column])
        if len(rows) < 2 * FEWEST:
            continue
        rest, stamp = off[rows] / noise, span.stamp[rows]
        found = jumps(stamp, rest, worth, len(rest))
        cuts = [0, *stamp.searchsorted(found).tolist(), len(rest)]
        for before, cut, after, at in zip(cuts, cuts[1:], cuts[2:], found, strict=False):
            if _is_at_once(rest[before:cut], rest[cut:after]):
                yield float(at)


def _is_at_once(before: Array, after: Array) -> bool:
    """Whether a residual of unit noise, flat (n,) and flat (m,) but for a jump in between, moves there by far
    more than before and after: what goes by the angles of other joints moves on with them.
    """
    size = min(len(before) // 2, len(after) // 2, ENOUGH)
    if size < BRIEF:
        return False
    means = [
        part.mean()
        for part in (before[-2 * size : -size], before[-size:], after[:size], after[size : 2 * size])
    ]
    left, now, right = np.abs(np.diff(means))
    return bool(now > THREEFOLD * max(left, right) + SURE * np.sqrt(2.0 / size))


@compiled
def rests(path: Array, rows: np.ndarray, ratio: float, least: float) -> list[tuple[int, int]]:
    """First and last of ``rows`` (n,), the last one excluded, between which a path (m,) of a gearbox moves
    its joint by no more than ``least`` rad, for ``FEWEST`` rows and longer.
    """
    out, first = [(0, 0)], 0
    while first < len(rows) - FEWEST:
        last = goes_on(path, rows, first + 1, ratio, least)
        if last - first >= FEWEST:
            out.append((first, last))
            first = last
        else:
            first += 1
    return out[1:]
