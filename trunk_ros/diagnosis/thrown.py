"""What happens at once to a joint that rests throws it: its mass takes it on beyond where the play would have
pushed it, and there it lies in its dead band until it moves again. How far no recording tells beforehand.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array, compiled
from trunk_ros.diagnosis.data.surroundings import View
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import FEWEST, PART, TOGETHER
from trunk_ros.diagnosis.machine import make_room
from trunk_ros.diagnosis.search.course import Course
from trunk_ros.effects import effect
from trunk_ros.effects.moments import RISE
from trunk_ros.parameter import GROWN


class Rest(NamedTuple):
    """A joint that rests from a moment [s] on: the rows of the target at which it does, the first one after
    the moment, and how many rad what happens moves it where nothing holds it, if it says so.
    """

    still: slice
    first: int
    at: float
    size: float = 0.0


class Throw(NamedTuple):
    """When [s] and how far [rad] a joint was thrown, and for how many samples that was seen."""

    at: float
    far: float
    seen: int


def rests(view: View, hypothesis: Hypothesis, column: int) -> list[Rest]:
    """Where a joint with a dead band rests from a moment of its effects on, or from a knock on, one after the
    other: each until it goes on, or the next one begins where enough is seen until then.
    """
    if view.arm.dead_band[column] <= 0.0:
        return []
    moments = _moments(hypothesis, column)
    knocks = [at for c, at in view.span.knocks if c == column]
    moments |= {at: 0.0 for at in knocks if all(abs(at - told) > TOGETHER for told in moments)}
    found = []
    for at, size in sorted(moments.items()):
        if (column, at) not in view.rests:  # a fit asks again and again
            make_room(view.rests, 1, view.rests)
            view.rests[column, at] = _rest(view, column, at)
        rest = view.rests[column, at]
        if rest is not None:
            found.append(rest._replace(size=size))
    for k, (rest, later) in enumerate(pairwise(found)):
        still = slice(rest.still.start, min(rest.still.stop, later.first))
        if np.count_nonzero(view.columns[column].valid[still]) >= FEWEST:
            found[k] = rest._replace(still=still)
    return found


def _rest(view: View, column: int, at: float) -> Rest | None:
    """The rest of a joint from a moment [s] on, None where it goes on."""
    stamp, valid, rows = view.span.stamp, view.span.valid[:, column], view.span.rows
    first, done = int(stamp.searchsorted(at - RISE / 2)), int(stamp.searchsorted(at + RISE / 2))
    if not 0 < first < len(valid) - FEWEST:
        return None
    path, ratio = view.span.gearbox[:, column], float(view.arm.ratio[column])
    still = slice(done, goes_on(path, rows, first, ratio, PART * float(view.arm.dead_band[column])))
    return None if np.count_nonzero(valid[still]) < FEWEST else Rest(still, first, at)


@compiled
def goes_on(path: Array, rows: np.ndarray, first: int, ratio: float, least: float) -> int:
    """The first of ``rows`` (n,) from ``first`` on at which a path (m,) of a gearbox has moved its joint by
    more than ``least`` rad since the row before; their number where it nowhere has.
    """
    for k in range(first, len(rows)):
        if abs((path[rows[k]] - path[rows[first - 1]]) * ratio) > least:
            return k
    return len(rows)


def thrown(view: View, column: int, found: Sequence[Rest], predicted: Array) -> Array:
    """(n,) rad: ``predicted`` (n,) with each throw of the rests as far as was measured, within the dead
    band.
    """
    out, seen, band = predicted, view.columns[column], room(view.arm, column)
    path, ratio = view.span.gearbox[:, column], float(view.arm.ratio[column])
    for still, first, at, size in found:
        pushed = predicted[still.start] - predicted[first - 1]
        mean = mean_off(seen.target[still], out[still], seen.valid[still])
        way, most = np.sign(pushed), band
        if abs(pushed) < PART * band / 2:  # held by friction, it goes on a part of the way, if that is said
            way, most = np.sign(size or mean), abs(size) or band
        gone = way * (out[first - 1] - predicted[first - 1])  # by knocks before
        far = float(np.clip(way * mean, 0.0, max(min(most, band - gone), 0.0)))
        if far > 0.0:
            out = out.copy() if out is predicted else out
            throw(out, view.span.stamp, path, view.span.rows, first, at, ratio, far, band, float(way))
    return out


def room(arm: Arm, column: int) -> float:
    """How many rad a joint has from one end of its dead band to the other."""
    return 2.0 * float(arm.dead_band[column])


def throws(view: View, column: int, found: Sequence[Rest], predicted: Array) -> Iterator[Throw]:
    """How far each throw takes a joint on beside what is ``predicted`` (n,) rad."""
    change, valid = thrown(view, column, found, predicted) - predicted, view.columns[column].valid
    for still, first, at, _ in found:
        far = float(change[still.start] - change[first - 1])
        yield Throw(at, far, int(np.count_nonzero(valid[still])))


@compiled
def mean_off(target: Array, predicted: Array, valid: np.ndarray) -> float:
    """The mean of what is left where it counts, each (n,); NaN where nothing does."""
    total, count = 0.0, 0
    for k in range(len(target)):
        if valid[k]:
            total, count = total + target[k] - predicted[k], count + 1
    return total / count


@compiled
def throw(
    out: Array, stamp: Array, path: Array, rows: np.ndarray, first: int, at: float, ratio: float, far: float,
    band: float, way: float,
) -> None:  # fmt: skip
    """Throw a joint ``far`` rad at a moment [s], ahead or back (``way``: 1 or -1), in ``out`` (n,) rad at
    ``stamp`` (n,) s, until its motor has moved it on by as much or back by the rest of the ``band`` [rad].
    ``path`` (m,) rad of the gearbox, at ``rows`` (n,).
    """
    on, back = 0.0, 0.0
    for k in range(first, len(out)):
        moved = way * ratio * (path[rows[k]] - path[rows[first - 1]])
        on, back = max(on, moved), max(back, -moved)
        left = min(far - on, band - back, far)
        if left <= 0.0:
            return
        out[k] += way * left * min((stamp[k] - at) / RISE + 0.5, 1.0)


def _moments(hypothesis: Hypothesis, column: int) -> dict[float, float]:
    """When [s] something happens to a joint at once, and how many rad it moves it where it says so."""
    out = dict[float, float]()
    for term in hypothesis.values():
        if column in term.own:
            values = {**term.shared, **term.own[column]}
            if _all_moments(term.effect).isdisjoint(values):  # asked at each prediction
                continue
            lead = _size(term.effect)
            size = float(values.get(lead, 0.0))
            out |= {values[name]: size for name in _names(term.effect) if name in values}
            course = Course.of(values if lead else {})
            for at, before, after in zip(course.moments, course.sizes, course.sizes[1:], strict=False):
                out[at] = size * (after - before)
    return out


@cache
def _names(name: str) -> tuple[str, ...]:
    """Of a named effect's moments at which something happens to a joint at once: motors lie in no band."""
    kind = effect(name)
    every = (*kind.parameters, *kind.moments()) if kind.named and kind.stage == "wire" else ()
    return tuple(p.name for p in every if p.moment and p.name != GROWN.name)


@cache
def _all_moments(name: str) -> frozenset[str]:
    """Names of all its values that are times."""
    kind = effect(name)
    return frozenset(p.name for p in (*kind.parameters, *kind.moments()) if p.moment)


@cache
def _size(name: str) -> str:
    """The parameter that says how far an effect moves a joint at its moment, if that is all that it does."""
    lead, *others = effect(name).parameters
    return lead.name if lead.unit == "rad" and any(p.moment for p in others) else ""
