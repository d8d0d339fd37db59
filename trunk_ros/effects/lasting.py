"""When an effect begins and ends, where it does not act all the time: a screw comes loose, a weight is
taken up.

It acts from its ``from`` until its ``until``; the friction element goes on remembering.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import NEVER

RISE = 0.02  # s, so that a fit can move a moment
MOMENTS = ("from", "until", "grown")


class Payload(NamedTuple):
    """A mass [kg] at the tip, and when [s] it is taken up and put down."""

    mass: float = 0.0
    begin: float = 0.0
    until: float = NEVER

    @property
    def always(self) -> bool:
        """Whether it is there from beginning to end."""
        return self.begin <= 0.0 and self.until >= NEVER

    @property
    def own(self) -> float:
        """kg that the arm has from beginning to end."""
        return self.mass if self.always else 0.0

    def lasts(self, stamp: float) -> bool:
        """Whether it is carried at a time [s]."""
        return self.begin <= stamp < self.until

    def at(self, stamp: Array) -> Array:
        """(n, 1) kg at ``stamp`` (n,) s."""
        return self.mass * share(stamp, np.array([self.begin]), np.array([self.until]))


NOTHING = Payload()


def share(stamp: Array, begin: Array, until: Array, grown: Array | float = 0.0) -> Array:
    """(n, columns) from 0 to 1: what acts from ``begin`` until ``until`` (columns,) s; ``stamp`` (n,) s.

    ``grown`` (columns,) s: when it has its full size, 0 for at once.
    """
    whole = np.zeros(np.broadcast(begin, until, grown).size)
    out = np.empty((len(stamp), len(whole)))
    _share(stamp, whole + begin, whole + until, whole + grown, out)
    return out


@compiled
def _share(stamp: Array, begin: Array, until: Array, grown: Array, out: Array) -> None:
    for j in range(len(begin)):
        rise = max(grown[j] - begin[j], RISE)
        middle = begin[j] + rise / 2 if grown[j] > begin[j] else begin[j]
        always = begin[j] <= 0.0 and grown[j] <= 0.0
        for k in range(len(stamp)):
            begun = 1.0 if always else min(max((stamp[k] - middle) / rise + 0.5, 0.0), 1.0)
            ended = min(max((stamp[k] - until[j]) / RISE + 0.5, 0.0), 1.0) if until[j] < NEVER else 0.0
            out[k, j] = begun * (1.0 - ended)


def lasts(e: Effect) -> bool:
    """Whether an effect acts all the time."""
    return e.values.keys().isdisjoint(MOMENTS)


def acting(e: Effect, now: Now) -> Array:
    """(n, columns): how much of an effect acts; kept with it, as a fit asks again and again."""
    kept = e.acts
    if kept is None or kept[0] is not now.stamp:
        nothing = np.zeros_like(now.ratio)
        begin, until = e.values.get("from", nothing), e.values.get("until", nothing + NEVER)
        e.acts = kept = now.stamp, share(now.stamp, begin, until, e.values.get("grown", nothing))
    return kept[1]


def run(e: Effect, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
    """``Effect.run`` while it acts."""
    y, state = e.run(x, now, state)
    return (y if lasts(e) else x + acting(e, now) * (y - x)), state


def invert(e: Effect, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
    """``Effect.invert`` while it acts."""
    x, state = e.invert(y, now, state)
    return (x if lasts(e) else y + acting(e, now) * (x - y)), state


def adjust(e: Effect, core: Core, now: Now) -> None:
    """``Effect.adjust`` while it acts: of a friction element its width and middle may change in mid-run."""
    width, middle = core.width, core.middle
    e.adjust(core, now)
    if not lasts(e):
        acts = acting(e, now)
        core.width = width + acts * (core.width - width)
        core.middle = middle + acts * (core.middle - middle)
