"""What happens at once to a joint that rests throws it: its mass takes it on beyond where the play would have
pushed it, and there it lies in its dead band until it moves again. How far no recording tells beforehand.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from functools import cache, lru_cache, partial
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array, compiled
from trunk_ros.data.surroundings import View
from trunk_ros.diagnosis.hypothesis import Hypothesis, Numbers
from trunk_ros.diagnosis.search.course import Course
from trunk_ros.effects import effect
from trunk_ros.effects.moments import RISE
from trunk_ros.levels import FEWEST, PART, TOGETHER
from trunk_ros.machine import BOUND, FOUND, make_room
from trunk_ros.parameter import GROWN

Found = TypeVar("Found")

REST = np.dtype([("begin", int), ("end", int), ("first", int), ("at", float), ("size", float)])
"""A joint rests from a moment ``at`` [s] on: the rows of the target from ``begin`` to ``end`` at which it
does, the ``first`` one after the moment, and how many rad what happens moves it where nothing holds it, if it
says so.
"""
NOWHERE = np.empty(0, REST)
NOWHERE.flags.writeable = False


class Throw(NamedTuple):
    """When [s] and how far [rad] a joint was thrown, and for how many samples that was seen."""

    at: float
    far: float
    seen: int


def rests(view: View, hypothesis: Hypothesis, column: int) -> np.ndarray:
    """(k,) of ``REST``: where a joint with a dead band rests from a moment of its effects on, or from a knock
    on, one after the other, each until it goes on, or the next one begins where enough is seen until then.
    """
    if view.arm.dead_band[column] <= 0.0:
        return NOWHERE
    moments = _moments(hypothesis, column)
    if not moments and not view.span.knocks:
        return NOWHERE
    every = tuple(moments.items())
    return _kept(view, (column, every), lambda: _rests(view, column, moments))


def _rests(view: View, column: int, moments: dict[float, float]) -> np.ndarray:
    knocks = [at for c, at in view.span.knocks if c == column]
    every = moments | {at: 0.0 for at in knocks if all(abs(at - told) > TOGETHER for told in moments)}
    each = [(_kept(view, (column, at), partial(_rest, view, column, at)), every[at]) for at in sorted(every)]
    out, valid = np.array([(*rest, size) for rest, size in each if rest], REST), view.columns[column].valid
    for rest, later in pairwise(out):
        end = min(rest["end"], later["first"])
        if np.count_nonzero(valid[rest["begin"] : end]) >= FEWEST:
            rest["end"] = end
    return out


def _rest(view: View, column: int, at: float) -> tuple[int, int, int, float] | None:
    """The rest of a joint from a moment [s] on, None where it goes on."""
    stamp, valid, rows = view.span.stamp, view.columns[column].valid, view.span.rows
    first, done = int(stamp.searchsorted(at - RISE / 2)), int(stamp.searchsorted(at + RISE / 2))
    if not 0 < first < len(valid) - FEWEST:
        return None
    path, ratio = view.of(column)[0][:, 0], float(view.arm.ratio[column])
    end = goes_on(path, rows, first, ratio, PART * float(view.arm.dead_band[column]))
    return None if np.count_nonzero(valid[done:end]) < FEWEST else (done, end, first, at)


def _kept(view: View, key: tuple[int, Hashable], make: Callable[[], Found]) -> Found:
    """What was found of a column once: a fit asks again and again."""
    if key not in view.rests:
        make_room(view.rests, FOUND, view.rests)
        view.rests[key] = make()
    found: Found = view.rests[key]
    return found


@compiled
def goes_on(path: Array, rows: np.ndarray, first: int, ratio: float, least: float) -> int:
    """The first of ``rows`` (n,) from ``first`` on at which a path (m,) of a gearbox has moved its joint by
    more than ``least`` rad since the row before; their number where it nowhere has.
    """
    for k in range(first, len(rows)):
        if abs((path[rows[k]] - path[rows[first - 1]]) * ratio) > least:
            return k
    return len(rows)


def thrown(view: View, column: int, found: np.ndarray, predicted: Array) -> Array:
    """(n,) rad: ``predicted`` (n,) with each throw of the rests that were ``found`` (k,) as far as was
    measured, within the dead band.
    """
    if not len(found):
        return predicted
    out, seen, path = predicted.copy(), view.columns[column], view.of(column)[0][:, 0]
    ratio, band = float(view.arm.ratio[column]), room(view.arm, column)
    _throw_all(
        found, seen.target, seen.valid, predicted, view.span.stamp, path, view.span.rows, ratio, band, out
    )
    return out


@compiled
def _throw_all(
    found: np.ndarray, target: Array, valid: np.ndarray, predicted: Array, stamp: Array, path: Array,
    rows: np.ndarray, ratio: float, band: float, out: Array,
) -> None:  # fmt: skip
    for rest in found:
        begin, first = rest.begin, rest.first
        pushed = predicted[begin] - predicted[first - 1]
        mean = _mean_off(target, out, valid, begin, rest.end)
        way, most = np.sign(pushed), band
        if abs(pushed) < PART * band / 2:  # held by friction, it goes on a part of the way, if that is said
            way, most = np.sign(rest.size or mean), abs(rest.size) or band
        gone = way * (out[first - 1] - predicted[first - 1])  # by knocks before
        far = min(max(way * mean, 0.0), max(min(most, band - gone), 0.0))
        if far > 0.0:
            _throw(out, stamp, path, rows, first, rest.at, ratio, far, band, way)


def room(arm: Arm, column: int) -> float:
    """How many rad a joint has from one end of its dead band to the other."""
    return 2.0 * float(arm.dead_band[column])


def throws(view: View, column: int, found: np.ndarray, predicted: Array) -> Iterator[Throw]:
    """How far each throw takes a joint on beside what is ``predicted`` (n,) rad."""
    change, valid = thrown(view, column, found, predicted) - predicted, view.columns[column].valid
    for begin, end, first, at, _ in found.tolist():
        far = float(change[begin] - change[first - 1])
        yield Throw(at, far, int(np.count_nonzero(valid[begin:end])))


@compiled
def _mean_off(target: Array, predicted: Array, valid: np.ndarray, begin: int, end: int) -> float:
    """The mean of what is left where it counts, each (n,), in some rows; NaN where nothing does."""
    total, count = 0.0, 0
    for k in range(begin, end):
        if valid[k]:
            total, count = total + target[k] - predicted[k], count + 1
    return total / count


@compiled
def _throw(
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
            times, shared, own = _all_moments(term.effect), term.shared, term.own[column]
            if times.isdisjoint(own) and times.isdisjoint(shared):  # asked at each prediction
                continue
            out.update(_happens(term.effect, tuple(shared.items()), tuple(own.items())))
    return out


@lru_cache(BOUND)
def _happens(name: str, shared: Numbers, own: Numbers) -> tuple[tuple[float, float], ...]:
    """When [s] an effect with such values does something at once, and by how many rad."""
    values = {**dict(shared), **dict(own)}
    lead = _size(name)
    size = float(values.get(lead, 0.0))
    out = {values[moment]: size for moment in _names(name) if moment in values}
    course = Course.of(values if lead else {})
    for at, before, after in zip(course.moments, course.sizes, course.sizes[1:], strict=False):
        out[at] = size * (after - before)
    return tuple(out.items())


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
