"""When an effect may begin and end: a linear look at all times at once, by sums over them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.diagnosis.search.course import Course
from trunk_ros.effects.lasting import shown_between
from trunk_ros.effects.moments import LASTING
from trunk_ros.guards import ROUNDED
from trunk_ros.parameter import FROM, GROWN, MANY, UNTIL

EDGES = 100  # moments of a recording that are looked at
FINE = 41  # moments around each of those that gain most

Reach = tuple[float, float]
"""Least and greatest multiple of itself that a change may be taken at."""
Seen = tuple[Array, Array, Array, Array]
"""Of a joint: stamp, rest and change d (n,), and what the fitted values can follow (n, basis)."""
Shape = Callable[["Sums"], tuple[Array, Array]]


@dataclass(frozen=True)
class Sums:
    """Sums of rest . d, d . d and q . d from the beginning until each edge, and of the same times t and t^2:
    they answer for every window, whether d is there at once or grows in it.
    """

    at: Array
    """(k,) s, the edges."""
    rd: Array
    """(2, k): times 1 and t."""
    dd: Array
    """(3, k): times 1, t and t^2."""
    qd: Array
    """(2, k, basis): times 1 and t."""

    @staticmethod
    def of(edges: Array, stamp: Array, rest: Array, d: Array, q: Array) -> Sums:
        """``rest``, ``d`` (n,) at ``stamp`` (n,) s; ``q`` (n, basis): what the fitted values can follow."""
        basis = q.shape[1]
        sums = np.zeros((5 + 2 * basis, len(edges)))
        _between(np.searchsorted(stamp, edges), stamp, rest, d, q, sums)
        sums = sums.cumsum(axis=1)
        qd = np.ascontiguousarray(sums[5:].reshape(2, basis, len(edges)).transpose(0, 2, 1))
        return Sums(np.clip(edges, stamp[0], stamp[-1]), sums[:2], sums[2:5], qd)

    def between(self) -> tuple[Array, Array]:
        """(k, k) rest . d and d . d from one edge to another, less what the fitted values can follow."""
        qd = _inside(self.qd[0])
        return _inside(self.rd[0]), _inside(self.dd[0]) - np.sum(qd**2, axis=2)

    def growing(self) -> tuple[Array, Array]:
        """(k, k) the same of a d that grows from nothing at one edge to its full size at another."""
        t = self.at[:, None]
        span = np.maximum(self.at[None, :] - t, 1e-9)
        once, twice = (_inside(self.rd[1]) - t * _inside(self.rd[0])) / span, t**2 * _inside(self.dd[0])
        square = (_inside(self.dd[2]) - 2 * t * _inside(self.dd[1]) + twice) / span**2
        qd = (_inside(self.qd[1]) - t[:, :, None] * _inside(self.qd[0])) / span[:, :, None]
        qd = qd + (self.qd[0, -1] - self.qd[0])[None]
        rd, dd = (sums[0, -1] - sums[0] for sums in (self.rd, self.dd))
        return once + rd[None], square + dd[None] - np.sum(qd**2, axis=2)

    def stepping(self) -> tuple[Array, Array]:
        """(k, 2) rest . d and (k, 2, 2) d . d of a d before each edge and of the rest of it."""
        (qd, *_), whole = self.qd, self.qd[0, -1]
        parts = np.stack([qd, whole - qd], axis=1)
        rd = np.stack([self.rd[0], self.rd[0, -1] - self.rd[0]], axis=1)
        dd = np.stack([self.dd[0], self.dd[0, -1] - self.dd[0]], axis=1)
        return rd, dd[:, :, None] * np.eye(2) - parts @ parts.transpose(0, 2, 1)


@compiled
def _between(rows: np.ndarray, stamp: Array, rest: Array, d: Array, q: Array, out: Array) -> None:
    """Sums (5 + 2 basis, k) over the rows (k,) before each edge that are not before the one before it."""
    first, basis = 0, q.shape[1]
    for k in range(len(rows)):
        for i in range(first, rows[k]):
            t, along, own = stamp[i], rest[i] * d[i], d[i] * d[i]
            out[0, k] += along
            out[1, k] += along * t
            out[2, k] += own
            out[3, k] += own * t
            out[4, k] += own * t * t
            for j in range(basis):
                fitted = q[i, j] * d[i]
                out[5 + j, k] += fitted
                out[5 + basis + j, k] += fitted * t
        first = rows[k]


def _inside(sums: Array) -> Array:
    """(k, k, …) from one edge to another, of sums (k, …) until each."""
    return np.asarray(sums[None] - sums[:, None])


@dataclass(frozen=True)
class Window:
    """When (s) an effect acts, and its products there, as if it had one size."""

    moments: dict[str, float]
    """``from``, ``until`` and ``grown``, as far as they are not the beginning or the end of the recording; or
    ``from_2`` and ``times_2``.
    """
    rd: float
    dd: float
    price: float
    """Of its moments, and of a second size."""

    @property
    def size(self) -> float:
        """By how much the change is multiplied where it gains most."""
        return self.rd / max(self.dd, ROUNDED)

    @property
    def ends(self) -> tuple[float, float]:
        """When it begins and ends [s], as one window; infinite where it does not."""
        return self.moments.get(FROM.name, -np.inf), self.moments.get(UNTIL.name, np.inf)

    @property
    def worth(self) -> float:
        """What it gains at that size, less its price."""
        return self.rd * self.size - self.price

    def gain(self, within: Reach) -> float:
        """What it gains at a size that may be."""
        return float(gained(np.array(self.rd), np.array(self.dd), within))


class Prices(NamedTuple):
    """Of a moment, and of a further size."""

    moment: float
    size: float

    def of(self, course: Course) -> float:
        """Of all that a course says."""
        return self.moment * len(course.moments) + self.size * max(len({*course.sizes} - {0.0}) - 1, 0)


def best_course(
    seen: list[Seen], stamp: Array, within: Reach, prices: Prices, grows: bool = False
) -> Window | None:
    """The times, and the sizes at them, in which changes of several joints gain most together; None where
    they do as well from beginning to end. ``stamp`` (n,) s of the recording; ``grows``: it may do so little
    by little.

    One window after the other is found in what those before it leave.
    """
    best = best_window(seen, stamp, within, prices, grows, steps=within[0] < within[1])
    if best is None or GROWN.name in best.moments or within[0] == within[1]:
        return best
    course = Course.of(best.moments)
    while (more := _one_more(seen, stamp, course, best.size, prices)) is not None:
        others = more, more.rounded(), *more.without_the_least()
        tries = [_sized(seen, one, within, prices) for one in dict.fromkeys(others) if one.values()]
        found = max(filter(None, tries), key=lambda f: f[1].worth, default=None)
        if found is None or found[1].worth <= best.worth:
            break
        course, best = found
    return best


def _one_more(seen: list[Seen], stamp: Array, course: Course, size: float, prices: Prices) -> Course | None:
    """A course with the window that gains most beside it, ``size`` being its first."""
    left = []
    for at, rest, d, q in seen:
        more = rest - size / course.first * course.at(at) * d
        left.append((at, more - q @ (q.T @ more), d, q))
    window = best_window(left, stamp, (-np.inf, np.inf), prices)
    if window is None:
        return None
    return course.plus(window.size * course.first / size, *window.ends).plain()


def _sized(seen: list[Seen], course: Course, within: Reach, prices: Prices) -> tuple[Course, Window] | None:
    """A course with the sizes that gain most, those that are equal still being so."""
    levels = sorted({*course.sizes} - {0.0})
    normal, along = np.zeros((len(levels), len(levels))), np.zeros(len(levels))
    for stamp, rest, d, q in seen:
        at = course.at(stamp)
        parts = np.where(at[:, None] == levels, d[:, None], 0.0)
        parts -= q @ (q.T @ parts)
        normal, along = normal + parts.T @ parts, along + parts.T @ rest
    sizes = np.linalg.lstsq(normal, along, rcond=None)[0]
    if not np.all((sizes >= within[0]) & (sizes <= within[1]) & (sizes != 0.0)):
        return None
    taken = dict(zip(levels, map(float, sizes), strict=True)) | {0.0: 0.0}
    there = Course(tuple(taken[s] for s in course.sizes), course.moments).plain()
    moments, gain, first = there.values(), float(along @ sizes), there.first
    if moments is None or gain <= 0.0:
        return None
    return there, Window(moments, gain / first, gain / first**2, prices.of(there))


def best_window(
    seen: list[Seen], stamp: Array, within: Reach, prices: Prices, grows: bool = False, steps: bool = False
) -> Window | None:
    """The same of one window; ``steps``: or of two sizes, one after the other.

    What gains most at a hundred moments is looked at again at those between them.
    """
    edges = np.linspace(*shown_between(stamp), EDGES)
    found = _best_at(edges, seen, within, prices, grows, steps)
    near = (edges[1] - edges[0]) * np.linspace(-1.0, 1.0, FINE)
    if found is None:
        return None
    moments = np.array([found.moments[m.name] for m in LASTING if m.moment and m.name in found.moments])
    edges = np.unique(np.clip(moments[:, None] + near, edges[0], edges[-1]))
    return _best_at(edges, seen, within, prices, grows, steps) or found


def _best_at(
    edges: Array, seen: list[Seen], within: Reach, prices: Prices, grows: bool, steps: bool
) -> Window | None:
    """The best window between some edges [s], the beginning and the end."""
    edges = np.concatenate([[-np.inf], edges, [np.inf]])
    sums = [Sums.of(edges, *one) for one in seen]
    inside = np.isfinite(edges)
    later = np.arange(len(edges))[:, None] < np.arange(len(edges))[None, :]
    count = prices.moment * (inside[:, None].astype(float) + inside[None, :])
    found = [_lasting(sums, edges, UNTIL.name, Sums.between, within, count, later)]
    if grows:
        found.append(_lasting(sums, edges, GROWN.name, Sums.growing, within, count, later & inside[None, :]))
    if steps:
        found.append(_changing(sums, edges, within, sum(prices)))
    best, worth = max(found, key=lambda one: one[1])
    return best if best.moments and worth > 0.0 else None


def _lasting(
    sums: list[Sums], edges: Array, end: str, shape: Shape, within: Reach, prices: Array, may: np.ndarray
) -> tuple[Window, float]:
    """The best window of one shape, and what it is worth."""
    parts = [shape(one) for one in sums]
    rd, dd = (np.sum([part[k] for part in parts], axis=0) for k in (0, 1))
    worth = np.where(may, gained(rd, dd, within) - prices, -np.inf)
    i, j = np.unravel_index(int(np.argmax(worth)), worth.shape)
    ends = {FROM.name: float(edges[i]), end: float(edges[j])}
    moments = {name: t for name, t in ends.items() if np.isfinite(t)}
    return Window(moments, float(rd[i, j]), float(dd[i, j]), float(prices[i, j])), float(worth[i, j])


def _changing(sums: list[Sums], edges: Array, within: Reach, price: float) -> tuple[Window, float]:
    """The best moment of a change from one size to another, and what it is worth."""
    parts = [one.stepping() for one in sums]
    rd, dd = (np.sum([part[k] for part in parts], axis=0)[1:-1] for k in (0, 1))
    ridge = ROUNDED * np.trace(dd, axis1=1, axis2=2)[:, None, None] * np.eye(2) + ROUNDED * np.eye(2)
    sizes = np.linalg.solve(dd + ridge, rd[:, :, None])[:, :, 0]
    one, two = sizes.T
    may = np.all((sizes > within[0]) & (sizes < within[1]), axis=1) & (np.abs(two) < MANY * np.abs(one))
    worth = np.where(may, np.sum(sizes * rd, axis=1) - price, -np.inf)
    k = int(np.argmax(worth))
    if not np.isfinite(worth[k]):
        return Window({}, 0.0, 0.0, 0.0), -np.inf
    gain, size = float(worth[k]) + price, float(one[k])
    moments = Course((1.0, float(two[k] / one[k])), (float(edges[k + 1]),)).values() or {}
    return Window(moments, gain / size, gain / size**2, price), float(worth[k])


def gained(rd: Array, dd: Array, within: Reach) -> Array:
    """What a change of these products gains (…), at the multiple of its size that gains most."""
    factor = np.clip(rd / np.maximum(dd, ROUNDED), *within)
    return np.asarray(factor * (2 * rd - factor * dd))
