"""Where a joint lies as its recording begins: by what its sensor reads while its motor stands."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.data.motion_content import STANDS
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.effects.wire.presliding_hysteresis import SOLVED, RoundedPlay
from trunk_ros.levels import HARDLY, TURNS
from trunk_ros.stage import Memory, Order, adjusted, through


class Read(NamedTuple):
    """What a joint's sensor reads (k,) while its motor stands: until each of some moments, and since the one
    before.
    """

    until: Array
    since: Array

    @staticmethod
    def of(told: Array, until: np.ndarray, since: np.ndarray) -> Read:
        """Of readings ``told`` (n,), so many ``until`` each moment, and ``since`` the one before, (k,)."""
        return Read(
            np.array([np.median(told[:count]) for count in until]),
            np.array([np.median(told[a:b]) for a, b in zip(since, until, strict=True)]),
        )


def begun(seen: Now, order: Order, width: Array, read: Read, rows: list[int] | slice) -> Any:
    """As ``held``, by what comes to the element in the ``seen`` surroundings while the motor stood, of which
    ``rows`` (k,) count: what swings is computed at each step.
    """
    core, memory = Core(nominal_width=width, width=width), Memory()
    adjusted(core, order, seen, {}, memory)
    u = through(seen.gearbox * seen.ratio, order.path, seen, {}, memory) + core.middle
    return held(u, core, core.width, order, seen, read, rows)


def held(
    u: Array, core: Core, width: Array, order: Order, seen: Now | None, read: Read, rows: list[int] | slice
) -> Any:
    """The memory with which the friction element shows what was measured, as far as its play lets it, while
    nothing had moved what comes to it, ``u`` (n, columns); of a sharp play as long as that holds the joint.
    ``seen``: the surroundings then, where effects behind the friction ask for them.
    """
    element, memory = core.rounding or SharpPlay(), Memory()
    moved, _ = element.run(u, width, None)
    shown = moved
    if seen is not None:
        shown = through(through(moved, order.after, seen, {}, memory), order.sensor, seen, {}, memory)
    wide = width[rows] if len(width) > 1 else width
    off = np.empty(u.shape[1])
    _lies(_c(u[rows]), _c(wide), _c(moved[rows]), _c(shown[rows]), *read, core.rounding is None, off)
    came = off if core.rounding is None else _comes_from(core.rounding, u[0], width[:1], off)
    return element.run(np.stack([u[0] + came, u[0]]), width[:1], None)[1]


def _comes_from(element: RoundedPlay, at: Array, width: Array, off: Array) -> Array:
    """How far away (columns,) rad what comes to a rounded element ``at`` (columns,) rad was before, where it
    lies ``off`` (columns,) rad: it goes back at once by a part of the way, the more the further that was.
    """
    led, came, before, lay = np.stack([at, at]), off, np.zeros_like(off), np.zeros_like(off)
    for _ in range(SOLVED):
        led[0] = at + came
        lies = element.run(led, width, None)[0][1] - at
        way, lacks, gained = came - before, off - lies, lies - lay
        more = gained * way > HARDLY**2 * way**2  # else it lies as far off as it can
        goes = more & (np.abs(lacks) > HARDLY**2 * STANDS)
        if not goes.any():
            break
        further = lacks * way / np.where(goes, gained, np.inf)
        before, lay, came = came, lies, came + further
    return came


def _c(signal: Array) -> Array:
    """A signal (k, columns) as what is compiled for one order in memory takes it."""
    return np.ascontiguousarray(signal)


@compiled
def _lies(
    u: Array, width: Array, moved: Array, shown: Array, until: Array, since: Array, sharp: bool, off: Array
) -> None:
    """How far ``off`` (columns,) rad joints lie from where their plays, of half-width ``width`` (1 or k,
    columns), begin: what comes to a play is ``u`` (k, columns) rad, and makes it show ``shown`` where it has
    ``moved`` to. What was read is (k,).
    """
    some = np.empty(len(u))
    for j in range(u.shape[1]):
        last = 0
        while last + 1 < len(u) and abs(u[last + 1, j] - u[0, j]) < STANDS:
            last += 1
        first = min(last, 1)
        for k in range(first, last + 1):
            some[k - first] = shown[k, j]
        off[j] = until[last] - _middle(some, last + 1 - first)
        if sharp:
            off[j] = _while_held(u[:, j], width[:, j], moved[:, j], shown[:, j], since, off[j], some)


@compiled
def _while_held(
    u: Array, width: Array, moved: Array, shown: Array, read: Array, off: float, some: Array
) -> float:
    """How far [rad] a joint lies off where its play began, by what is ``read`` (k,) as long as that play
    holds it there, whatever has moved by then. Where the play lets go of it at once, as far ``off`` as it
    was.
    """
    before = 0
    for _ in range(TURNS):
        count = 0
        while count < len(u) and abs(u[count] - u[0] - off) <= width[min(count, len(width) - 1)]:
            count += 1
        count = max(count - 1, 0)
        if count == before:
            break
        for k in range(count):
            hidden = moved[k] - shown[k] + moved[k + 1] - shown[k + 1]
            some[k] = read[k + 1] - u[0] + hidden / 2.0
        if count:
            off = _middle(some, count)
        before = count
    return off


@compiled
def _middle(values: Array, count: int) -> float:
    """The median of the first of ``values`` (n,), which it sorts: they are few."""
    for k in range(1, count):
        here, i = values[k], k
        while i and values[i - 1] > here:
            values[i] = values[i - 1]
            i -= 1
        values[i] = here
    half = count // 2
    return float(values[half] if count % 2 else (values[half - 1] + values[half]) / 2.0)
