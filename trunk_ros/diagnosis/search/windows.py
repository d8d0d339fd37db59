"""When an effect may begin and end: a linear look at all times at once, by sums over them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.parameter import FROM, GROWN, UNTIL

EDGES = 100  # moments of a recording that are looked at
INSIDE = 0.03  # of a recording: nothing is said of a beginning nearer to its ends

Gain = Callable[[Array, Array], Array]
"""(rest . d, d . d) to what is gained by d."""
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
        rows = np.searchsorted(stamp, edges)

        def until(values: Array) -> Array:
            sums = np.cumsum(values, axis=0)
            return np.concatenate([np.zeros_like(sums[:1]), sums])[rows]

        along, own, fitted = rest * d, d * d, q * d[:, None]
        return Sums(
            np.clip(edges, stamp[0], stamp[-1]),
            np.array([until(along), until(along * stamp)]),
            np.array([until(own), until(own * stamp), until(own * stamp**2)]),
            np.array([until(fitted), until(fitted * stamp[:, None])]),
        )

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


def _inside(sums: Array) -> Array:
    """(k, k, …) from one edge to another, of sums (k, …) until each."""
    return np.asarray(sums[None] - sums[:, None])


def edges_of(stamp: Array) -> Array:
    """(k,) s: the beginning, moments inside, and the end."""
    first, span = stamp[0], stamp[-1] - stamp[0]
    inside = first + span * np.linspace(INSIDE, 1.0 - INSIDE, EDGES)
    return np.concatenate([[-np.inf], inside, [np.inf]])


@dataclass(frozen=True)
class Window:
    """When (s) an effect acts, and its products there."""

    moments: dict[str, float]
    """``from``, ``until`` and ``grown``, as far as they are not the beginning or the end of the recording."""
    rd: float
    dd: float
    price: float
    """Of its moments."""


def best_window(
    sums: list[Sums], edges: Array, gain: Gain, price: float, grows: bool = False
) -> Window | None:
    """The time in which an effect gains most, over all ``sums``, if each moment is worth a ``price``; None
    where it does as well from beginning to end. ``grows``: it may do so little by little.
    """
    inside = np.isfinite(edges)
    later = np.arange(len(edges))[:, None] < np.arange(len(edges))[None, :]
    count = inside[:, None].astype(float) + inside[None, :]
    shapes = [(UNTIL.name, Sums.between, later)]
    if grows:
        shapes.append((GROWN.name, Sums.growing, later & inside[None, :]))
    found = [_best(sums, edges, name, shape, gain, price * count, may) for name, shape, may in shapes]
    best, worth = max(found, key=lambda one: one[1])
    return best if best.moments and worth > 0.0 else None


def _best(
    sums: list[Sums], edges: Array, end: str, shape: Shape, gain: Gain, prices: Array, may: np.ndarray
) -> tuple[Window, float]:
    """The best window of one shape, and what it is worth."""
    parts = [shape(one) for one in sums]
    rd, dd = (np.sum([part[k] for part in parts], axis=0) for k in (0, 1))
    worth = np.where(may, gain(rd, dd) - prices, -np.inf)
    i, j = np.unravel_index(int(np.argmax(worth)), worth.shape)
    ends = {FROM.name: float(edges[i]), end: float(edges[j])}
    moments = {name: t for name, t in ends.items() if np.isfinite(t)}
    return Window(moments, float(rd[i, j]), float(dd[i, j]), float(prices[i, j])), float(worth[i, j])
