"""When an effect may begin and end: a linear look at all times at once, by sums over them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import NEVER

EDGES = 100  # moments that are looked at
INSIDE = 0.03  # of a recording: nothing is said of a beginning nearer to its ends

Gain = Callable[[Array, Array], Array]
"""(rest . d, d . d) to what is gained by d."""


@dataclass(frozen=True)
class Sums:
    """Sums from the beginning until each edge: of rest . d (k,), d . d (k,), and q . d (k, basis)."""

    rd: Array
    dd: Array
    qd: Array

    @staticmethod
    def of(edges: Array, stamp: Array, rest: Array, d: Array, q: Array) -> Sums:
        """``rest``, ``d`` (n,) at ``stamp`` (n,) s; ``q`` (n, basis): what the fitted values can follow."""
        rows = np.searchsorted(stamp, edges)

        def until(values: Array) -> Array:
            sums = np.cumsum(values, axis=0)
            return np.concatenate([np.zeros_like(sums[:1]), sums])[rows]

        return Sums(until(rest * d), until(d * d), until(q * d[:, None]))

    def between(self) -> tuple[Array, Array]:
        """(k, k) rest . d and d . d from one edge to another, less what the fitted values can follow."""
        rd = self.rd[None, :] - self.rd[:, None]
        qd = self.qd[None, :, :] - self.qd[:, None, :]
        return rd, self.dd[None, :] - self.dd[:, None] - np.sum(qd**2, axis=2)


def edges_of(stamp: Array) -> Array:
    """(k,) s: the beginning, moments inside, and the end."""
    first, span = stamp[0], stamp[-1] - stamp[0]
    inside = first + span * np.linspace(INSIDE, 1.0 - INSIDE, EDGES)
    return np.concatenate([[-np.inf], inside, [np.inf]])


@dataclass(frozen=True)
class Window:
    """From when until when (s) an effect acts, and its products there."""

    begin: float
    until: float
    rd: float
    dd: float
    price: float
    """Of its moments."""

    @property
    def moments(self) -> dict[str, float]:
        """Those that are neither the beginning nor the end of the recording."""
        ends = {"from": self.begin, "until": self.until}
        return {name: t for name, t in ends.items() if 0.0 < t < NEVER}


def best_window(sums: list[Sums], edges: Array, gain: Gain, price: float) -> Window | None:
    """The time in which an effect gains most, over all ``sums``, if each end of it is worth a ``price``; None
    where it does as well from beginning to end.
    """
    parts = [one.between() for one in sums]
    rd, dd = (np.sum([part[k] for part in parts], axis=0) for k in (0, 1))
    prices = price * (np.isfinite(edges)[:, None].astype(float) + np.isfinite(edges)[None, :])
    worth = gain(rd, dd) - prices
    order = np.arange(len(edges))
    worth[order[:, None] >= order[None, :]] = -np.inf
    i, j = np.unravel_index(int(np.argmax(worth)), worth.shape)
    if i == 0 and j == len(edges) - 1:
        return None
    begin, until = max(float(edges[i]), 0.0), min(float(edges[j]), NEVER)
    return Window(begin, until, float(rd[i, j]), float(dd[i, j]), float(prices[i, j]))
