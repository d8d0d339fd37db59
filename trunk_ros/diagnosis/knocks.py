"""Where a joint at rest is knocked: what its neighbours do shakes it elsewhere within its dead band, and it
lies there until its own motor moves it on. That says where it happened to lie, and nothing of its wire.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.surroundings import View
from trunk_ros.diagnosis.discrepancy.jumps import jumps
from trunk_ros.diagnosis.levels import FEWEST, PART, SURE, THREEFOLD
from trunk_ros.diagnosis.search.score import SIGNIFICANT, chance
from trunk_ros.diagnosis.thrown import goes_on

BESIDE = 8  # samples on each side of a moment: a knock is over within a few


def told_from_knocks(context: Context) -> Context:
    """With the moments at which joints that rest are knocked within their dead bands."""
    if context.stage.name != "wire":
        return context
    views = tuple(_knocked(context, index, view) for index, view in enumerate(context.views))
    if all(new is old for new, old in zip(views, context.views, strict=True)):
        return context
    return replace(context, views=views, shown_before={}, _cache={}).weighed(context.known)


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
        rest = off[rows] / noise
        for at in jumps(span.stamp[rows], rest, worth, len(rest)):
            if _is_at_once(rest, int(np.searchsorted(span.stamp[rows], at))):
                yield float(at)


def _is_at_once(rest: Array, cut: int) -> bool:
    """Whether a residual (n,) of unit noise moves there by far more than in as many samples before and after:
    what goes by the angles of other joints moves on with them.
    """
    parts = [rest[max(cut + k * BESIDE, 0) : max(cut + (k + 1) * BESIDE, 0)] for k in (-2, -1, 0, 1)]
    if min(map(len, parts)) < BESIDE:
        return False
    before, now, after = np.diff([np.median(part) for part in parts])
    other = max(abs(before), abs(after))
    return bool(abs(now) > max(THREEFOLD * other, SURE / np.sqrt(BESIDE)))


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
