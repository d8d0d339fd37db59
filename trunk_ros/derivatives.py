"""Speed and acceleration of an angle: live, from the past alone, or of a recording, from both sides."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled

LAG = 0.015  # s, twice: how much later a live acceleration is, for an encoder step to cost 0.01 mrad of sag
HALF_WINDOW = 0.06  # s of a recording on either side that an acceleration is taken from
FAR = 0.2  # s to the next sample from which on nothing is known of what lies between


@compiled
def follow(x: Array, dt: Array, memory: Array, speed: Array, acceleration: Array) -> None:
    """Speed and acceleration (n, columns) of ``x`` from the past alone: those of two lags of LAG in a row.

    Exact for inputs that run straight between uneven samples. ``memory`` (3, columns): the last input and
    both lags' outputs. White noise of ``s`` rad at ``dt`` = LAG gives some 0.3 s/LAG^2 rad/s^2.
    """
    steps, columns = x.shape
    for k in range(steps):
        decay = np.exp(-max(dt[k], 0.0) / LAG)
        share = max(dt[k], 0.0) / LAG * decay  # of what the first lag is off, in the second
        for j in range(columns):
            old, one, two = memory[0, j], memory[1, j], memory[2, j]
            slope = (x[k, j] - old) / dt[k] if dt[k] > 0.0 else 0.0
            first, second = one - (old - slope * LAG), two - (old - 2.0 * slope * LAG)
            memory[0, j] = x[k, j]
            memory[1, j] = x[k, j] - slope * LAG + decay * first
            memory[2, j] = x[k, j] - 2.0 * slope * LAG + decay * second + share * first
            speed[k, j] = (memory[1, j] - memory[2, j]) / LAG
            acceleration[k, j] = (x[k, j] - 2.0 * memory[1, j] + memory[2, j]) / LAG**2


def gradient(x: Array, stamp: Array) -> Array:
    """(n,) slopes of ``x`` (n,) at each stamp (n,), as ``np.gradient``, which takes eight times the room."""
    out = np.empty_like(stamp)
    slopes(x, stamp, out)
    return out


@compiled
def slopes(x: Array, stamp: Array, out: Array) -> None:
    """The same; ``out`` (n,)."""
    last = len(x) - 1
    for k in range(1, last):
        before, after = stamp[k] - stamp[k - 1], stamp[k + 1] - stamp[k]
        a = -after / (before * (before + after))
        b = (after - before) / (before * after)
        c = before / (after * (before + after))
        out[k] = a * x[k - 1] + b * x[k] + c * x[k + 1]
    out[0] = (x[1] - x[0]) / (stamp[1] - stamp[0])
    out[last] = (x[last] - x[last - 1]) / (stamp[last] - stamp[last - 1])


@compiled
def local_parabola(stamp: Array, x: Array, half: float, out: Array) -> None:
    """Parabolas fitted to ``x`` (n, columns) within ``half`` s of each stamp (n,): level, slope and curvature
    there, ``out`` (3, n, columns).

    The sample before and the one after count in any case, unless they are FAR; of too few samples slope or
    curvature are 0. Savitzky & Golay (1964), Anal. Chem. 36(8), for uneven stamps.
    """
    steps, columns = x.shape
    first = end = 0
    for k in range(steps):
        while stamp[first] < stamp[k] - half:
            first += 1
        while end < steps and stamp[end] <= stamp[k] + half:
            end += 1
        a = first - 1 if first == k and k > 0 and stamp[k] - stamp[k - 1] < FAR else first
        b = end + 1 if end == k + 1 and end < steps and stamp[end] - stamp[k] < FAR else end
        s = (stamp[a:b] - stamp[k]) / half
        middle = s.mean()
        one = s - middle
        square = (one * one).sum()
        skew = (s * s * one).sum() / square if square > 0.0 else 0.0
        level = (s * s).mean()
        two = s * s - level - skew * one
        bend = (two * two).sum()
        for j in range(columns):
            mean = x[a:b, j].sum() / (b - a)
            rise = (one * x[a:b, j]).sum() / square if square > 0.0 else 0.0
            curve = (two * x[a:b, j]).sum() / bend if bend > 1e-9 * (b - a) else 0.0
            out[0, k, j] = mean - rise * middle + curve * (skew * middle - level)
            out[1, k, j] = (rise - curve * skew) / half
            out[2, k, j] = 2.0 * curve / half**2


def smooth(stamp: Array, x: Array, half: float = HALF_WINDOW) -> tuple[Array, Array, Array]:
    """Level, slope and curvature (n, columns) of a recorded signal, from both sides of each stamp.

    Of n even samples in ``half`` s on either side, white noise ``s`` becomes a curvature of some
    4.7 s/(half^2 sqrt(n)), and what swings ``f`` times a second loses (2 pi f half)^2/14 of it.
    """
    out = np.empty((3, *x.shape))
    local_parabola(stamp, np.ascontiguousarray(x), half, out)
    return out[0], out[1], out[2]
