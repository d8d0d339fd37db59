"""Whether the motion of a recording can show what a hypothesis says."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from functools import partial

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.cubic import DEGREE, cubic
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term, bind_column
from trunk_ros.effects import Effect, effect
from trunk_ros.effects.effect import Now
from trunk_ros.effects.lasting import shown_between
from trunk_ros.effects.moments import LASTING, RISE
from trunk_ros.levels import HARDLY, PART, SEVERAL, SURE, TOGETHER
from trunk_ros.parameter import GROWN

BY_THE_WAY = ("reversal", "low_speed", "high_speed", "hold")  # regimes of what acts by how a joint moves


class Shown(IntEnum):
    """How a joint shows an effect: by itself, or beside another joint that does."""

    NOT = 0
    BESIDE = 1
    ALONE = 2


def unshown(context: Context, hypothesis: Hypothesis) -> int:
    """On how many joints an effect is past what their motion can show, or lacks what it has to stand on."""
    return sum(len(hidden(context, term)) for term in hypothesis.values()) + sum(
        effect(term.effect).beyond not in ("", *(other.effect for other in hypothesis.on(column)))
        for column in context.wide
        for term in hypothesis.on(column)
    )


def hidden(context: Context, term: Term) -> list[int]:
    """The joints of a term whose motion does not show it."""
    shown = {c: _shown(context, term, c) for c in context.judged(term)}
    alone = {c for c, level in shown.items() if level == Shown.ALONE}
    return [c for c, level in shown.items() if level < (Shown.BESIDE if alone - {c} else Shown.ALONE)]


def ends_within(block: Effect, now: Now, jumps: Callable[[float], bool] = lambda _: False) -> bool:
    """Whether what begins or ends does so while it is looked at, not at an edge of the recording: the joint
    or what it follows moves, or its load changes, on both sides of each moment, as far as to the next one; or
    on one side, where it rests at the moment and ``jumps`` all the same. Of joints that move one after the
    other none shows that. What acts by the way of the motion has to be seen on the same way on both sides: if
    it was there on one way and not on the way back, it went by the direction. What grows does so under way.
    Between two moments what it follows takes no smooth course of time, or a push from outside would show its
    law as well.
    """
    times, grown = _moments(block), block.values.get(GROWN.name)
    if not times and grown is None:
        return True
    first, last = shown_between(now.stamp)
    if times and not first <= times[0] <= times[-1] <= last:
        return False
    followed = {word for words in block.words.values() for word in words if word in now.joints}
    signals = [now.gearbox[:, 0], *(now.angles[:, now.joints.index(joint)] for joint in followed)]
    signals += [now.load[:, 0]] if block.bears(block.form) else []
    rows = np.split(np.arange(len(now.stamp)), np.searchsorted(now.stamp, times))
    seen = _ways if block.regime in BY_THE_WAY else _moves
    goes = np.array([[seen(signal, part) for part in rows] for signal in signals])
    if not all(any(_winds(now.stamp, signal, part) for signal in signals) for part in rows[1:-1]):
        return False
    if grown is not None:
        growing = np.arange(*np.searchsorted(now.stamp, [min(times, default=-np.inf), float(grown[0])]))
        if not any(any(seen(signal, growing)) for signal in signals):
            return False
    both = (goes[:, :-1] & goes[:, 1:]).any(axis=(0, 2))
    either = (goes[:, :-1] | goes[:, 1:]).any(axis=(0, 2))
    return all(b or (e and jumps(t)) for b, e, t in zip(both, either, times, strict=True))


def _moments(block: Effect) -> list[float]:
    """When [s] an effect begins, changes and ends, one after the other."""
    names = (m.name for m in LASTING if m.moment and m is not GROWN)
    return sorted(t for name in names for t in block.values.get(name, ()))


def _jumps(context: Context, term: Term, column: int, at: float) -> bool:
    """Whether an effect makes a joint that rests at a moment [s] jump then by more than its noise."""
    hypothesis, near = Hypothesis({term.effect: term}), max(TOGETHER, (SEVERAL + 1) * context.step)
    for index, view in enumerate(context.views):
        seen, stamp, gearbox = (
            view.columns[column],
            view.span.stamp,
            view.span.gearbox[view.span.rows, column],
        )
        before, after = (
            seen.valid & (low < stamp) & (stamp < high)
            for low, high in ((at - near, at - RISE / 2), (at + RISE / 2, at + near))
        )
        if min(np.count_nonzero(before), np.count_nonzero(after)) < SEVERAL:
            continue
        if np.ptp(gearbox[before | after]) > HARDLY * np.ptp(gearbox):
            continue
        # no work of the search: what is kept of it on another core is lost, and the count would differ
        moved, still = (context.stage.predict(context, index, h, column) for h in (hypothesis, Hypothesis()))
        change = moved - still
        if abs(change[after].mean() - change[before].mean()) > SURE * context.noise[column].std:
            return True
    return False


def _moves(signal: Array, part: np.ndarray) -> tuple[bool]:
    """Whether a signal (n,) changes in some rows of it."""
    return (bool(len(part) and np.ptp(signal[part]) > PART * np.ptp(signal)),)


def _winds(stamp: Array, signal: Array, part: np.ndarray) -> bool:
    """Whether a signal (n,) at ``stamp`` (n,) s is in some rows of it more than a smooth course of time,
    which has with its two ends as many values as a push.
    """
    if len(part) <= DEGREE + 1 or np.ptp(signal) == 0.0:
        return False
    smooth = cubic(stamp[part], signal[part], stamp[part])
    return bool(np.ptp(signal[part] - smooth) > PART * np.ptp(signal))


def _ways(signal: Array, part: np.ndarray) -> tuple[bool, bool]:
    """Whether a signal (n,) rises, and whether it falls, in some rows of it."""
    if not len(part):
        return False, False
    there, least = signal[part], PART * np.ptp(signal)
    rise = np.max(there - np.minimum.accumulate(there))
    fall = np.max(np.maximum.accumulate(there) - there)
    return bool(rise > least), bool(fall > least)


def _shown(context: Context, term: Term, column: int) -> int:
    key = (column, *term.key(column))
    if key not in context.shown_before:
        block = bind_column(term, column)
        told = partial(ends_within, block, jumps=partial(_jumps, context, term, column))
        alone = context.shows(block.credible, column) and context.shows(told, column)
        near = alone or context.shows(partial(block.credible, beside=True), column)
        context.shown_before[key] = Shown.ALONE if alone else Shown.BESIDE if near else Shown.NOT
    return context.shown_before[key]
