"""Where a joint at rest is knocked: what its neighbours do shakes it elsewhere within its dead band, and it
lies there until its own motor moves it on. That says where it happened to lie, and nothing of its wire.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.data.sensing.pairs import told
from trunk_ros.data.surroundings import View
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.jumps import jumps
from trunk_ros.diagnosis.disturbances.thrown import goes_on, rests, throws
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.score import BETTER, SIGNIFICANT, chance, choice
from trunk_ros.levels import ENOUGH, FEWEST, PART
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.signal.resample import SLOW
from trunk_ros.recording.topics import TOPICS
from trunk_ros.units import sized

BRIEF = 8  # samples in which a knock is over; twice as many at least tell what is on each side


def with_knocks(context: Context) -> Context:
    """With the moments at which joints that rest are knocked within their dead bands."""
    if context.stage.name != "wire" or context.step >= SLOW:
        return context
    views = [_knocked(context, index, view) for index, view in enumerate(context.views)]
    if all(new is old for new, old in zip(views, context.views, strict=True)):
        return context
    return context.viewing(views).weighed(context.known)


def knocks_told(context: Context, hypothesis: Hypothesis, index: int) -> Iterator[Observed]:
    """What to say of the knocks in a recording that are none of what a hypothesis says happened: of joints
    that turn, and of those that slide.
    """
    view, far = context.views[index], dict[str, dict[str, list[float]]]()
    for c in sorted({c for c, _ in view.span.knocks}):
        predicted = context.stage.predict(context, index, hypothesis, c)
        moved = throws(view, c, rests(view, hypothesis, c), predicted)
        own = [abs(throw.far) for throw in moved if (c, throw.at) in view.span.knocks]
        if seen := [one for one in own if one > context.noise[c].std]:
            far.setdefault(context.stage.unit(c), {})[context.joints[c]] = seen
    for unit, by_joint in far.items():
        most = max(map(max, by_joint.values()))
        said = (
            f"{', '.join(by_joint)}: shaken elsewhere within the dead band while at rest, by what moved "
            f"beside it, {sum(map(len, by_joint.values()))} times, by up to {sized(most, unit, 2)}. Where a "
            "joint lies in it says nothing of its wire, and was fitted"
        )
        yield told("knocks", (TOPICS["joint_states"], tuple(by_joint)), most, None, unit, said)


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
    for first, last in standing(view.span.gearbox[:, column], span.rows, ratio, least):
        rows = first + np.flatnonzero(span.valid[first:last, column])
        if len(rows) < 2 * FEWEST:
            continue
        rest, stamp = off[rows] / noise, span.stamp[rows]
        cuts = stamp.searchsorted(jumps(stamp, rest, worth, ENOUGH))
        if 0 < len(cuts) < ENOUGH:  # else it goes by something
            yield from (float(stamp[at]) for at in _at_once(rest, cuts))


def _at_once(rest: Array, cuts: np.ndarray) -> Iterator[int]:
    """Where a residual (n,) of unit noise, flat between cuts (k,), jumps at once: no passage that takes
    longer explains it as well. What goes by the angles of other joints moves on with them.
    """
    groups = np.split(cuts, np.flatnonzero(np.diff(cuts) >= BRIEF) + 1)  # a reading in between is a piece
    before = [0, *(int(group[-1]) for group in groups[:-1])]
    after = [*(int(group[0]) for group in groups[1:]), len(rest)]
    for group, first, last in zip(groups, before, after, strict=True):
        near = range(max(group[0] - BRIEF, 0), min(group[-1] + BRIEF, len(rest)))
        middle = max(near, key=lambda k: _step(rest, k))
        size = min(middle - first, last - middle, ENOUGH)
        if size >= 2 * BRIEF and _is_brief(rest[middle - size : middle + size], BETTER + choice(len(groups))):
            yield middle


def _step(rest: Array, at: int) -> float:
    """How far a residual (n,) moves within ``BRIEF`` samples."""
    return abs(float(rest[at : at + BRIEF].mean() - rest[max(at - BRIEF, 0) : max(at, 1)].mean()))


def _is_brief(rest: Array, better: float) -> bool:
    """Whether a change in the middle of a residual (n,) is over within ``BRIEF`` samples: that explains it
    ``better``.
    """
    apart = np.arange(len(rest)) - (len(rest) - 1) / 2
    gains = {}
    for lasts in (1, BRIEF // 2, *range(2 * BRIEF, len(rest) + 1, BRIEF)):
        passage = np.clip(apart / lasts, -0.5, 0.5)
        gains[lasts] = float(rest @ passage) ** 2 / float(passage @ passage)
    longer = max(gain for lasts, gain in gains.items() if lasts > BRIEF)
    return max(gain for lasts, gain in gains.items() if lasts <= BRIEF) > longer + better


@compiled
def standing(path: Array, rows: np.ndarray, ratio: float, least: float) -> list[tuple[int, int]]:
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
