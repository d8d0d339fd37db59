"""Reference motions of a minute: one function per kind, all within the joint limits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from test.concealed.nominal import COUNT, LIMIT, Array

REACH = 0.87 * LIMIT
KINDS = ("sweep", "single", "multisine", "ptp", "fast", "mixed")


def rise(x: Array) -> Array:
    """Minimum-jerk step from 0 to 1."""
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x**2)


def _triangle(rng: np.random.Generator, t: Array) -> Array:
    phase = t / rng.uniform(9.0, 16.0) + rng.uniform()
    out: Array = rng.uniform(0.2, REACH) * (4 * np.abs(phase - np.floor(phase + 0.5)) - 1)
    return out


def _chirp(rng: np.random.Generator, t: Array) -> Array:
    first, last = rng.uniform(0.03, 0.06), rng.uniform(0.2, 0.5)
    phase = first * t + (last - first) * t**2 / (2 * t[-1])
    out: Array = rng.uniform(0.15, REACH) * np.sin(2 * np.pi * (phase + rng.uniform()))
    return out


def _small(rng: np.random.Generator, t: Array) -> Array:
    """Reversals of small and growing amplitude on a slow carrier."""
    carrier = rng.uniform(0.1, 0.25) * np.sin(2 * np.pi * (t / rng.uniform(20, 40) + rng.uniform()))
    grow = np.geomspace(0.002, rng.uniform(0.03, 0.08), t.size)
    return carrier + grow * np.sin(2 * np.pi * (t * rng.uniform(0.2, 0.6) + rng.uniform()))


def _sweep(rng: np.random.Generator, t: Array) -> Array:
    form = rng.choice(3, p=[0.6, 0.25, 0.15])
    return np.stack([(_triangle, _chirp, _small)[form](rng, t) for _ in range(COUNT)], axis=1)


def _single(rng: np.random.Generator, t: Array) -> Array:
    """One joint after the other; the others stand where they are."""
    slot = t[-1] / COUNT
    turns = rng.uniform(1.2, 3.2, COUNT) / slot
    clock = np.clip(t[:, None] - slot * np.arange(COUNT), 0.0, slot)
    out: Array = rng.uniform(0.8, 1.0, COUNT) * REACH * np.sin(2 * np.pi * turns * clock)
    return out


def _multisine(rng: np.random.Generator, t: Array, top: float = 0.45) -> Array:
    out = np.zeros((t.size, COUNT))
    for j in range(COUNT):
        rate = np.exp(rng.uniform(np.log(0.03), np.log(top), 7))
        out[:, j] = np.sin(2 * np.pi * (t[:, None] * rate + rng.uniform(size=7))).sum(axis=1)
    out *= REACH / np.abs(out).max(axis=0)
    return out


def _moves(rng: np.random.Generator, t: Array, hold: tuple[float, float], move: tuple[float, float]) -> Array:
    """Point to point: holds and minimum-jerk moves of random length."""
    out = np.empty((t.size, COUNT))
    for j in range(COUNT):
        x = np.full(t.size, rng.uniform(-REACH, REACH))
        clock = rng.uniform(0.0, hold[1])
        while clock < t[-1]:
            took, now = rng.uniform(*move), x[-1]
            x += (rng.uniform(-REACH, REACH) - now) * rise((t - clock) / took)
            clock += took + rng.uniform(*hold)
        out[:, j] = x
    return out


def _ptp(rng: np.random.Generator, t: Array) -> Array:
    return _moves(rng, t, (0.5, 5.0), (0.8, 4.0))


def _fast(rng: np.random.Generator, t: Array) -> Array:
    return _moves(rng, t, (0.2, 1.5), (0.25, 0.9))


def _mixed(rng: np.random.Generator, t: Array) -> Array:
    """Four kinds in a row, blended over a second."""
    parts = (_ptp(rng, t), _multisine(rng, t, 1.0), _sweep(rng, t), _fast(rng, t))
    order = rng.permutation(4)
    out = parts[order[0]]
    for n, which in enumerate(order[1:], 1):
        share = rise(t - n * t[-1] / 4)[:, None]
        out = (1 - share) * out + share * parts[which]
    return out


_MAKE: dict[str, Callable[[np.random.Generator, Array], Array]] = {
    "sweep": _sweep, "single": _single, "multisine": _multisine, "ptp": _ptp, "fast": _fast, "mixed": _mixed,
}  # fmt: skip


def draw_reference(rng: np.random.Generator, kind: str, stamp: Array) -> Array:
    """Wanted joint angles (n, 5) rad at the stamps (n,) s, of one of KINDS."""
    return np.clip(_MAKE[kind](rng, stamp), -LIMIT, LIMIT)
