"""When an effect begins and ends, where it does not act all the time: a screw comes loose, a weight is
taken up; and when it changes its size.

It acts from its ``from`` until its ``until``, from its ``from_2`` on with ``times_2`` of that size, and so
on; the friction element goes on remembering.
"""

from __future__ import annotations

from typing import Any

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.moments import NULLS, share
from trunk_ros.effects.wire.elements import Elements
from trunk_ros.effects.wire.play import SharpPlay

ENDS, SHOWN = 0.03, 20.0  # of a recording, and s at most, at its ends: no moment there shows before and after


def shown_between(stamp: Array) -> tuple[float, float]:
    """The first and last moment [s] that a recording at ``stamp`` (n,) s shows before and after."""
    margin = min(ENDS * float(stamp[-1] - stamp[0]), SHOWN)
    return float(stamp[0]) + margin, float(stamp[-1]) - margin


def lasts(e: Effect) -> bool:
    """Whether an effect acts all the time."""
    if e.lasts is None:  # asked at each prediction
        e.lasts = NULLS.keys().isdisjoint(e.values.keys())
    return e.lasts


def acting(e: Effect, now: Now) -> Array:
    """(n, columns): how much of an effect acts; kept with it, as a fit asks again and again: where a joint
    stood, and then for all of its way.
    """
    known = [one for one in e.acts if one[0] is now.stamp]
    known = known or [(now.stamp, share(now.stamp, e.values, len(now.ratio)))]
    e.acts = (*[one for one in e.acts if one[0] is not now.stamp][-1:], *known)
    return known[0][1]


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
