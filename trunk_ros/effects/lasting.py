"""When an effect begins and ends, where it does not act all the time: a screw comes loose, a weight is
taken up; and when it changes its size.

It acts from its ``from`` until its ``until``, from its ``from_2`` on with ``times_2`` of that size, and so
on; the friction element goes on remembering.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.wire.elements import Elements
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.parameter import FROM, GROWN, LATER, NEVER, SPELL_NAMES, UNTIL

RISE = 0.02  # s, so that a fit can move a moment
ENDS, SHOWN = 0.03, 20.0  # of a recording, and s at most, at its ends: no moment there shows before and after
LASTING = (FROM, UNTIL, GROWN, *LATER)
NULLS = {p.name: p.null for p in LASTING}


class Payload(NamedTuple):
    """A mass [kg] at the tip, and by the names of an effect's moments when [s] how much of it is there."""

    mass: float = 0.0
    when: tuple[tuple[str, float], ...] = ()

    @property
    def always(self) -> bool:
        """Whether it is there from beginning to end."""
        return not self.when

    @property
    def own(self) -> float:
        """kg that the arm has from beginning to end."""
        return self.mass if self.always else 0.0

    def at(self, stamp: Array) -> Array:
        """(n, 1) kg at ``stamp`` (n,) s."""
        return self.mass * self.share(stamp)

    def share(self, stamp: Array) -> Array:
        """(n, 1): how much of it is there at ``stamp`` (n,) s."""
        return share(stamp, {name: np.array([value]) for name, value in self.when}, 1)


NOTHING = Payload()


def shown_between(stamp: Array) -> tuple[float, float]:
    """The first and last moment [s] that a recording at ``stamp`` (n,) s shows before and after."""
    margin = min(ENDS * float(stamp[-1] - stamp[0]), SHOWN)
    return float(stamp[0]) + margin, float(stamp[-1]) - margin


def share(stamp: Array, values: Mapping[str, Any], columns: int) -> Array:
    """(n, columns): how much of its size acts at ``stamp`` (n,) s, by moments that are (columns,) or one."""
    first, *later = SPELL_NAMES
    said = [first, *(names for names in later if names[0] in values)]

    def of(name: str) -> Array:
        out = np.empty(columns)
        out[:] = values.get(name, NULLS[name])
        return out

    begin, until = (np.array([of(names[which]) for names in said]) for which in (0, 1))
    times = np.array([np.ones(columns), *(of(times) for *_, times in said[1:])])
    out = np.empty((columns, len(stamp))).T
    _share(stamp, begin, until, times, of(GROWN.name), out)
    return out


@compiled
def _ramp(stamp: float, middle: float, rise: float) -> float:
    return min(max((stamp - middle) / rise + 0.5, 0.0), 1.0)


@compiled
def _share(stamp: Array, begin: Array, until: Array, times: Array, grown: Array, out: Array) -> None:
    for j in range(len(grown)):
        rise = max(grown[j] - begin[0, j], RISE)
        middle = begin[0, j] + rise / 2 if grown[j] > begin[0, j] else begin[0, j]
        always = begin[0, j] <= 0.0 and grown[j] <= 0.0
        for k in range(len(stamp)):
            size = 1.0 if always else _ramp(stamp[k], middle, rise)
            for i in range(len(begin)):
                if i and begin[i, j] < NEVER:
                    begun = _ramp(stamp[k], begin[i, j], RISE) if begin[i, j] > 0.0 else 1.0
                    size += begun * (times[i, j] - size)
                if until[i, j] < NEVER:
                    size *= 1.0 - _ramp(stamp[k], until[i, j], RISE)
            out[k, j] = size


def lasts(e: Effect) -> bool:
    """Whether an effect acts all the time."""
    return NULLS.keys().isdisjoint(e.values)


def acting(e: Effect, now: Now) -> Array:
    """(n, columns): how much of an effect acts; kept with it, as a fit asks again and again."""
    kept = e.acts
    if kept is None or kept[0] is not now.stamp:
        e.acts = kept = now.stamp, share(now.stamp, e.values, len(now.ratio))
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
    """``Effect.adjust`` while it acts: the friction element, width and middle may change in mid-run."""
    width, middle, rounding = core.width, core.middle, core.rounding
    e.adjust(core, now)
    if not lasts(e):
        acts = acting(e, now)
        core.width = width + acts * (core.width - width)
        core.middle = middle + acts * (core.middle - middle)
        if core.rounding is not rounding:
            core.rounding = Elements(rounding or SharpPlay(), core.rounding, acts)
