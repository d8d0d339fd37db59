"""Wide loops of a residual over the motion, and what cannot be told from them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.drags import drag
from trunk_ros.guards import TINY
from trunk_ros.levels import NEARLY, PART

APART = 5  # samples whose noise has nothing in common, and between which a speed is no noise
PLACES = 20  # cells of a range, with as many samples each
VARIES = 0.2  # of the speed's power, beyond its means at each place and direction: from there on it tells
STILL = 0.02  # of the fastest, or of the largest motion: what does less stands
STANDS = 3e-4  # rad: a joint that moves less stands
MOVED = 0.15  # of the range: the way after which a joint has turned, and how it lay is forgotten


def is_wide(position: Array, residual: Array, shown: Array) -> bool:
    """Whether the residual (n,) of a joint on its way up and on its way down differs by much of the motion;
    of what the joint has ``shown`` (n,) of it, where nobody knew its ratio. In the mean over time: one that
    mostly rests shows more than a loop, which may be of lag. What is in proportion to the motion is no loop,
    and a motor that trembles where it rests goes neither way, whatever creeps there.
    """
    if not len(position) or np.ptp(position) == 0.0:
        return False
    about = position - np.mean(position)
    loop = residual - float(about @ residual) / float(about @ about) * about
    path = _untrembling(position)
    way = np.diff(path, prepend=path[0])
    goes = way != 0.0
    down, up = _means(_cells(position[goes], way[goes]), loop[goes]).reshape(2, PLACES)
    both = (up - down)[np.isfinite(up - down)]
    went, foretold = float(np.std(shown)), float(np.std(shown - residual))
    moved = float(np.std(position)) * (went / foretold if went < foretold else 1.0)
    return bool(both.size and np.sqrt(np.mean(both**2) * np.mean(goes)) > PART * moved)


def speed_tells(positions: Sequence[Array], speeds: Sequence[Array]) -> bool:
    """Whether a joint, (n,) in each recording, passes the same places in the same direction at different
    speeds, or rests.

    A motion to and fro that always looks the same has one speed for each place and direction. Where the
    residual is a wide loop as well, any lag is a form of that loop. So it is of the same motion in another
    size: it has another speed at each place, but it also turned elsewhere before, and a loop goes by that.
    """
    position, speed = _at_their_size(positions, speeds)
    power = float(np.sum(speed**2))
    if power == 0.0:
        return False
    cell = _cells(position, speed)
    varies = float(np.sum((speed - _means(cell, speed)[cell]) ** 2)) / power
    rests = float(np.mean(np.abs(speed) < STILL * np.abs(speed).max()))
    return varies > VARIES or rests > MOVED  # more than a swing takes to turn


def _at_their_size(positions: Sequence[Array], speeds: Sequence[Array]) -> tuple[Array, Array]:
    """Motions (n,) of recordings, joined: each about its own middle and in units of how far it goes."""
    ways = np.array([np.ptp(position) if len(position) else 0.0 for position in positions])
    ways[ways <= STILL * ways.max()] = max(float(ways.max()), TINY)  # what trembles there is no motion
    middles = [(p.max() + p.min()) / 2.0 if len(p) else 0.0 for p in positions]
    about = [(p - m) / way for p, m, way in zip(positions, middles, ways, strict=True)]
    return np.concatenate(about), np.concatenate([s / way for s, way in zip(speeds, ways, strict=True)])


def repeats(position: Array, speed: Array) -> bool:
    """Whether a joint (n,), once it has seen its whole range, passes places again in the same direction.

    Until then what it did before the recording is in any loop, and one that is gone through once is a matter
    of time as well as of the motion.
    """
    seen = _seen(position)
    return _again(position, speed, int(np.argmax(seen >= NEARLY * seen[-1]))) > PART


def passes_again(position: Array) -> bool:
    """Whether a joint (n,), once it has turned, passes places again in the same direction: how its loop
    changes from swing to swing is shown there. What it trembles by where it rests is no motion.
    """
    path = _untrembling(position)
    path = path[np.diff(path, prepend=np.nan) != 0.0]
    begin = turned(path)
    return bool(begin.any()) and _again(path, np.gradient(path), int(np.argmax(begin))) > STILL


def _untrembling(position: Array) -> Array:
    """(n,) the way of a joint without what it trembles by where it rests."""
    trembles = np.zeros(len(position))
    drag(position, np.array([STILL / 2 * np.ptp(position)]), np.ones(1), position[:1].copy(), trembles)
    return np.asarray(position - trembles)


def _again(position: Array, speed: Array, begin: int) -> float:
    """Share of the way of a joint (n,) on which it is, from a sample on, at places that it passes again in
    the same direction.
    """
    cell = _cells(position, speed)[begin:]
    way = np.abs(np.diff(position, prepend=position[0]))
    passages = np.concatenate([[0], np.flatnonzero(np.diff(cell)) + 1])
    again = np.ones(len(passages), dtype=bool)
    again[np.unique(cell[passages], return_index=True)[1]] = False
    return float(np.add.reduceat(way[begin:], passages)[again].sum() / max(way.sum(), TINY))


def comes_back(position: Array) -> bool:
    """Whether a joint (n,) ever comes back some way: one that goes on and on shows no reversal, and nothing
    that its posture could not do as well as time.
    """
    least = MOVED * float(np.ptp(position))
    up, down = np.maximum.accumulate(position) - position, position - np.minimum.accumulate(position)
    return bool(up.max() > least and down.max() > least)


def holds(position: Array) -> bool:
    """Whether a joint (n,) rests at one place for a good part of the time, however it trembles there."""
    moves = np.flatnonzero(np.diff(_untrembling(position)) != 0.0)
    edges = np.concatenate([[-1], moves, [len(position) - 1]])
    return bool(np.diff(edges).max() > PART * len(position))


def extent(angles: Array) -> Array:
    """(n, joints) how far joints at angles (n, joints) have been at most from where they began."""
    away = angles - angles[0]
    np.abs(away, out=away)
    return np.asarray(np.maximum.accumulate(away, axis=0, out=away))


def turned(position: Array) -> np.ndarray:
    """(n,) from where a joint has moved, turned and come back some way, or gone as far as ever: a wide play
    lies at its one side by then, wherever it lay when the recording began.
    """
    least = MOVED * float(np.ptp(position))
    away = np.abs(position - position[0])
    back = np.maximum.accumulate(away) - away > least
    seen = _seen(position)
    return np.asarray(np.maximum.accumulate(back | ((seen > 0.0) & (seen >= NEARLY * seen[-1]))))


def _seen(position: Array) -> Array:
    """(n,) the range that a joint has gone through so far."""
    return np.asarray(np.maximum.accumulate(position) - np.minimum.accumulate(position))


def passed(position: Array, speed: Array, seen: np.ndarray) -> np.ndarray:
    """(n,) where a joint is at a place that it passes in the same direction where it is ``seen`` (n,)."""
    cell = _cells(position, speed)
    return np.isin(cell, cell[seen])


def in_its_play(path: Array, half_width: float) -> Array:
    """(n,) from -1 to 1: where in a play of this half-width a joint is that follows a path (n,)."""
    out = np.zeros(len(path))
    drag(path, np.array([half_width]), np.ones(1), path[:1].copy(), out)
    return np.asarray(out / half_width)


def top_speed(stamp: Array, angle: Array) -> float:
    """rad/s of the fastest of some angles (n, joints)."""
    if len(stamp) <= APART:
        return 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.abs(angle[APART:] - angle[:-APART]) / (stamp[APART:] - stamp[:-APART])[:, None]
    return float(np.max(speed[np.isfinite(speed)], initial=0.0))


def _cells(position: Array, speed: Array) -> np.ndarray:
    """(n,) number of the place, those of the way up after those of the way down."""
    edges = np.quantile(position, np.linspace(0.0, 1.0, PLACES + 1)[1:-1])
    return np.asarray(np.searchsorted(edges, position) + PLACES * (speed > 0.0))


def _means(cell: np.ndarray, values: Array) -> Array:
    """(2 PLACES,) mean by cell, NaN where there is none."""
    counts = np.bincount(cell, minlength=2 * PLACES).astype(float)
    counts[counts == 0.0] = np.nan
    return np.asarray(np.bincount(cell, weights=values, minlength=2 * PLACES) / counts)
