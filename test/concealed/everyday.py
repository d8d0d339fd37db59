"""Motions of arms at work, none of which was made to identify anything: (n, 5) rad at stamps (n,) s."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from test.concealed.nominal import COUNT, LIMIT, Array
from test.concealed.trajectory import REACH, draw_reference, rise

Places = list[tuple[float, float, Array]]  # when a move begins (s), how long it takes (s), where to (5,) rad


def _through(t: Array, begin: Array, moves: Places) -> Array:
    out = np.tile(begin, (t.size, 1))
    for when, took, to in moves:
        out += rise((t - when) / took)[:, None] * (to - begin)
        begin = to
    return out


def _pose(rng: np.random.Generator) -> Array:
    return rng.uniform(-REACH, REACH, COUNT)


def _pick_and_place(rng: np.random.Generator, t: Array) -> Array:
    """Between a few taught places: over it, down, stand, up, on to the next."""
    over = [_pose(rng) for _ in range(int(rng.integers(2, 5)))]
    down = [np.clip(pose + rng.normal(0, 0.06, COUNT), -REACH, REACH) for pose in over]
    moves: Places = []
    clock, place = float(rng.uniform(0.5, 2.0)), 0
    while clock < t[-1]:
        place = int((place + rng.integers(1, len(over))) % len(over))
        for to, took, stands in ((over, 1.6, 0.1), (down, 0.7, 0.9), (over, 0.7, 0.1)):
            moves.append((clock, took * float(rng.uniform(0.9, 1.1)), to[place]))
            clock += 1.1 * took + stands
    return _through(t, over[0], moves)


def _one_by_one(rng: np.random.Generator, t: Array) -> Array:
    """Somebody at a teach pendant: one joint moves, then another."""
    moves: Places = []
    pose, clock = _pose(rng), float(rng.uniform(0.5, 2.0))
    begin = pose
    while clock < t[-1]:
        pose = pose.copy()
        pose[int(rng.integers(COUNT))] = rng.uniform(-REACH, REACH)
        took = float(rng.uniform(1.5, 2.5))
        moves.append((clock, took, pose))
        clock += took + float(rng.uniform(0.2, 1.0))
    return _through(t, begin, moves)


def _resting(rng: np.random.Generator, t: Array) -> Array:
    """Mostly at rest: five to eight moves in all."""
    begin = _pose(rng)
    when = np.sort(rng.uniform(0.05, 0.95, int(rng.integers(5, 9)))) * t[-1]
    return _through(t, begin, [(float(x), float(rng.uniform(1.5, 2.5)), _pose(rng)) for x in when])


def _small(rng: np.random.Generator, t: Array) -> Array:
    """Work around one place: moves of some hundredths of a radian."""
    middle, clock = 0.8 * _pose(rng), 0.5
    reach = float(rng.uniform(0.02, 0.06))
    moves: Places = []
    while clock < t[-1]:
        took = float(rng.uniform(0.4, 1.2))
        moves.append((clock, took, middle + rng.uniform(-reach, reach, COUNT)))
        clock += took + float(rng.uniform(0.1, 0.8))
    return _through(t, middle, moves)


def _cycle(rng: np.random.Generator, t: Array) -> Array:
    """The same few moves over and over."""
    places = [_pose(rng) for _ in range(int(rng.integers(3, 6)))]
    took, stands = rng.uniform(1.5, 2.5, len(places)), rng.uniform(0.2, 0.8, len(places))
    moves: Places = []
    clock, n = 0.5, 0
    while clock < t[-1]:
        n = (n + 1) % len(places)
        moves.append((clock, float(took[n]), places[n]))
        clock += float(took[n] + stands[n])
    return _through(t, places[0], moves)


def stations(rng: np.random.Generator, t: Array) -> Array:
    """A new place every second, reached in 0.6 s: stop, measure, go on."""
    moves = [(float(k), 0.6, 0.35 * _pose(rng)) for k in range(int(t[-1]) + 1)]
    return _through(t, 0.35 * _pose(rng), moves)


def turning(rng: np.random.Generator, t: Array) -> Array:
    """Mixed motion with one joint that turns on beyond half a turn."""
    out = draw_reference(rng, "mixed", t)
    period, far = float(rng.uniform(32.0, 45.0)), float(rng.uniform(3.3, 3.7))
    out[:, int(rng.integers(COUNT))] = far * np.sin(2 * np.pi * t / period)
    return out


EVERYDAY: dict[str, Callable[[np.random.Generator, Array], Array]] = {
    "pick_and_place": _pick_and_place, "one_by_one": _one_by_one, "resting": _resting, "small": _small,
    "cycle": _cycle,
}  # fmt: skip
_WIDE = {"stations": stations, "turning": turning}


def draw_motion(rng: np.random.Generator, kind: str, t: Array) -> Array:
    """Reference (n, 5) rad of an everyday kind, of stations or turning, or one of ``trajectory``."""
    if kind == "turning":
        return turning(rng, t)
    make = EVERYDAY.get(kind) or _WIDE.get(kind)
    return np.clip(make(rng, t), -LIMIT, LIMIT) if make else draw_reference(rng, kind, t)
