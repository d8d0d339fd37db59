"""Exact steps of linear dynamics for inputs that run straight between uneven samples (first-order hold)."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled

# Relative difference up to which two steps of time count as one, so that their exponentials are kept.
SAME = 1e-9
INSTANT = 1e-9  # s
BRIEF = 1e-6  # s: over less nothing is averaged
CRITICAL = 1e-6  # rad that a swing turns in a step: less is as good as critically damped


@compiled
def kept(dt: float, known: Array, last: int) -> tuple[int, bool]:
    """Which of two ``known`` (2,) steps ``dt`` is, and whether it has just taken the place of the one not
    used last: where two topics share a grid, two steps take turns.
    """
    for place in (last, 1 - last):
        if abs(dt - known[place]) <= SAME * known[place]:
            return place, False
    known[1 - last] = dt
    return 1 - last, True


@compiled
def lowpass(x: Array, dt: Array, time_constant: Array, before: Array, out: Array) -> None:
    """First-order lag of ``x`` (n, columns); ``before`` (2, columns) holds input and output of the sample
    before.
    """
    steps, columns = x.shape
    ramp, decay, known, s = np.empty(2), np.empty(2), np.empty(2), 0
    for j in range(columns):
        if j == 0 or time_constant[j] != time_constant[j - 1]:
            known[:] = -1.0
        old, y = before[0, j], before[1, j]
        for k in range(steps):
            s, new_step = kept(dt[k], known, s)
            if new_step:
                ramp[s], decay[s] = lag_step(dt[k], time_constant[j])
            new = x[k, j]
            y = (ramp[s] * new + (1.0 - ramp[s] - decay[s]) * old) + decay[s] * y
            old = new
            out[k, j] = y
        before[0, j], before[1, j] = old, y


@compiled
def lag_step(dt: float, time_constant: float) -> tuple[float, float]:
    """Shares of the new input and of the old output in the new output of a first-order lag; the old input
    has the rest.
    """
    if dt <= 0.0:
        return 0.0, 1.0
    if time_constant < INSTANT:
        return 1.0, 0.0
    decay = np.exp(-dt / time_constant)
    return 1.0 - time_constant / dt * (1.0 - decay), decay


@compiled
def oscillator(
    x: Array, dt: Array, omega: Array, zeta: Array, relative: bool, before: Array, out: Array
) -> None:
    """y'' + 2 zeta omega y' + omega^2 y = omega^2 x (damped against x where ``relative``); ``before``
    (3, columns) holds x, y and y' of the sample before.

    An ``omega`` of 0 stands for a rigid link.
    """
    steps, columns = x.shape
    swings, known, s = np.zeros((2, 5)), np.empty(2), 0
    for j in range(columns):
        if j == 0 or omega[j] != omega[j - 1] or zeta[j] != zeta[j - 1]:
            known[:] = -1.0
        old, y, rate = before[0, j], before[1, j], before[2, j]
        for k in range(steps):
            s, new_step = kept(dt[k], known, s)
            swing = swings[s]
            if new_step:
                swing_step(dt[k], omega[j], zeta[j], swing)
                if relative:
                    swing[4] = 0.0
            if dt[k] > 0.0:
                change = x[k, j] - old
                off, faster = y - old + swing[4] * change, rate - change / dt[k]
                y = x[k, j] - swing[4] * change + swing[0] * off + swing[1] * faster
                rate = change / dt[k] + swing[2] * off + swing[3] * faster
            old = x[k, j]
            out[k, j] = y
        before[0, j], before[1, j], before[2, j] = old, y, rate


@compiled
def swing_step(dt: float, omega: float, zeta: float, swing: Array) -> None:
    """Transition (2, 2) of the deviation from a ramp and its rate over ``dt``, and how far the link lags
    per change of the ramp.
    """
    swing[:] = 0.0
    if omega <= 0.0 or dt <= 0.0:
        return
    rest, turn = zeta * omega, omega * np.sqrt(abs(1.0 - zeta * zeta))
    if turn * dt < CRITICAL:
        c = np.exp(-rest * dt)
        s = c * dt
    elif zeta < 1.0:
        decay = np.exp(-rest * dt)
        c, s = decay * np.cos(turn * dt), decay * np.sin(turn * dt) / turn
    else:
        slow, fast = np.exp((turn - rest) * dt), np.exp(-(turn + rest) * dt)
        c, s = (slow + fast) / 2.0, (slow - fast) / (2.0 * turn)
    swing[0] = c + zeta * omega * s
    swing[1] = s
    swing[2] = -omega * omega * s
    swing[3] = c - zeta * omega * s
    swing[4] = 2.0 * zeta / (omega * dt)


def shifted(x: Array, dt: Array, delay: Array, longest: float, state: Any) -> tuple[Array, Any]:
    """``x`` (n, columns) ``delay`` (columns,) s late, none above ``longest``.

    State: stamps (m,) before the last sample, on a clock of their own since an effect's time may stand
    still, and inputs.
    """
    stamps, past = _after(state, x, dt)
    out = np.empty_like(x)
    delayed(stamps, past, delay, len(stamps) - len(x), out)
    return out, _kept_for(longest, stamps, past)


def averaged(
    x: Array, dt: Array, delay: Array, window: Array, longest: float, state: Any
) -> tuple[Array, Any]:
    """The mean of ``x`` (n, columns) over ``window`` (columns,) s about the time that is ``delay`` (columns,)
    s ago, none of them further back than ``longest``. After its last sample, and before its first one, it
    stands there. State: as of `shifted`.
    """
    stamps, past = _after(state, x, dt)
    out, skip, brief = np.empty_like(x), len(stamps) - len(x), window < BRIEF
    means(stamps, past, delay, window, skip, out)
    if brief.any():
        late = np.empty_like(x)
        delayed(stamps, past, delay, skip, late)
        out = np.where(brief, late, out)
    return out, _kept_for(longest, stamps, past)


def _after(state: Any, x: Array, dt: Array) -> tuple[Array, Array]:
    """Stamps (m,) and inputs (m, columns): those of a state, and after them ``x`` (n, columns)."""
    stamps, past = (np.zeros(0), x[:0]) if state is None else state
    stamps = np.concatenate([stamps, np.cumsum(dt) + (stamps[-1] if len(stamps) else 0.0)])
    return stamps, np.ascontiguousarray(np.concatenate([past, x]))


def _kept_for(longest: float, stamps: Array, past: Array) -> tuple[Array, Array]:
    """The state: what may be asked for again within ``longest`` s."""
    kept = max(int(np.searchsorted(stamps, stamps[-1] - longest)) - 2, 0)
    return stamps[kept:] - stamps[-1], past[kept:]


@compiled
def means(stamp: Array, x: Array, delay: Array, window: Array, skip: int, out: Array) -> None:
    """The same from row ``skip`` of ``x`` (m, columns) on, which goes straight from row to row."""
    rows, columns = x.shape
    for j in range(columns):
        width = max(window[j], BRIEF)
        first, last, areas = 0, 0, np.zeros(2)  # the rows at or before the window's ends, areas until there
        for k in range(rows):
            begin = stamp[k] - delay[j] - width / 2.0
            end = min(begin + width, stamp[k])
            while first < k and stamp[first + 1] <= begin:
                areas[0] += (x[first, j] + x[first + 1, j]) / 2.0 * (stamp[first + 1] - stamp[first])
                first += 1
            while last < k and stamp[last + 1] <= end:
                areas[1] += (x[last, j] + x[last + 1, j]) / 2.0 * (stamp[last + 1] - stamp[last])
                last += 1
            if k >= skip:
                area = areas[1] + part(stamp, x, j, last, end) - areas[0] - part(stamp, x, j, first, begin)
                out[k - skip, j] = (area + (begin + width - max(end, begin)) * x[k, j]) / width


@compiled
def part(stamp: Array, x: Array, j: int, row: int, until: float) -> float:
    """The area below a column of ``x`` (m, columns) from a row on; before the first it stands."""
    gone = until - stamp[row]
    if row + 1 >= len(stamp) or gone <= 0.0:
        return float(gone * x[row, j])
    slope = (x[row + 1, j] - x[row, j]) / (stamp[row + 1] - stamp[row])
    return float(gone * (x[row, j] + slope * gone / 2.0))


@compiled
def delayed(stamp: Array, x: Array, delay: Array, skip: int, out: Array) -> None:
    """``x`` (m, columns) as it was ``delay`` (columns,) s ago, from row ``skip`` on.

    Cubic (Catmull-Rom), using the past alone. A time that is a row's own gets that row alone.
    """
    rows, columns = x.shape
    for j in range(columns):
        late, m = delay[j], 0
        for k in range(skip, rows):
            t = stamp[k] - late
            if t <= stamp[0]:
                out[k - skip, j] = x[0, j]
                continue
            if t >= stamp[k]:
                out[k - skip, j] = x[k, j]
                continue
            while m + 1 < k and stamp[m + 1] < t:
                m += 1
            before, after = max(m - 1, 0), min(m + 2, k)
            h = stamp[m + 1] - stamp[m]
            s = (t - stamp[m]) / h
            bend = s * (1.0 - s) * h
            left = bend * (1.0 - s) / (stamp[m + 1] - stamp[before])
            right = bend * s / (stamp[after] - stamp[m])
            share = s * s * (3.0 - 2.0 * s)
            near = (1.0 - share + right) * x[m, j] + (share + left) * x[m + 1, j]
            out[k - skip, j] = near - left * x[before, j] - right * x[after, j]


def rate(y: Array, dt: Array, state: Array | None) -> tuple[Array, Array]:
    """Derivative of ``y`` (n, columns) from the past alone, second order where two samples lie behind.

    ``state`` (2 + 1, columns): the last two samples and, in the last row, the step between them.
    """
    columns = y.shape[1]
    tail = np.vstack([y[:1], y[:1], np.zeros((1, columns))]) if state is None else state.copy()
    out = np.empty_like(y)
    _rate(y, dt, tail, out)
    return out, tail


@compiled
def _rate(y: Array, dt: Array, tail: Array, out: Array) -> None:
    steps, columns = y.shape
    for j in range(columns):
        for k in range(steps):
            h = dt[k]
            h1 = tail[2, j]
            if h <= 0.0:
                out[k, j] = 0.0
            elif h1 <= 0.0:
                out[k, j] = (y[k, j] - tail[0, j]) / h
            else:
                new = (y[k, j] - tail[0, j]) / h
                old = (tail[0, j] - tail[1, j]) / h1
                out[k, j] = new + (new - old) * h / (h + h1)
            if h > 0.0:
                tail[1, j] = tail[0, j]
                tail[2, j] = h
            tail[0, j] = y[k, j]
