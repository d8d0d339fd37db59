"""Exact steps of linear dynamics for inputs that run straight between uneven samples (first-order hold)."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled


@compiled
def lowpass(x: Array, dt: Array, time_constant: Array, x_before: Array, y_before: Array, out: Array) -> None:
    """First-order lag of ``x`` (n, columns); ``x_before`` and ``y_before`` (columns,) are the state."""
    steps, columns = x.shape
    for j in range(columns):
        t = time_constant[j]
        last_dt = -1.0
        decay = 1.0
        for k in range(steps):
            if t < 1e-9:
                y_before[j] = x[k, j]
            elif dt[k] > 0.0:
                if dt[k] != last_dt:
                    last_dt = dt[k]
                    decay = np.exp(-last_dt / t)
                behind = (x[k, j] - x_before[j]) / last_dt * t
                y_before[j] = x[k, j] - behind + (y_before[j] - x_before[j] + behind) * decay
            x_before[j] = x[k, j]
            out[k, j] = y_before[j]


@compiled
def oscillator(x: Array, dt: Array, omega: Array, zeta: Array, state: Array, out: Array) -> None:
    """y'' + 2 zeta omega y' + omega^2 y = omega^2 x; ``state`` (3, columns) holds x, y and y' of the sample before."""
    steps, columns = x.shape
    for j in range(columns):
        w = omega[j]
        z = min(max(zeta[j], 0.0), 0.999)
        damped = w * np.sqrt(1.0 - z * z)
        last_dt = -1.0
        c, s = 1.0, 0.0
        for k in range(steps):
            if w <= 0.0:
                state[1, j] = x[k, j]
            elif dt[k] > 0.0:
                if dt[k] != last_dt:
                    last_dt = dt[k]
                    decay = np.exp(-z * w * last_dt)
                    c = decay * np.cos(damped * last_dt)
                    s = decay * np.sin(damped * last_dt)
                slope = (x[k, j] - state[0, j]) / last_dt
                behind = 2.0 * z * slope / w
                off = state[1, j] - state[0, j] + behind
                rate = state[2, j] - slope
                swing = (rate + z * w * off) / damped
                state[1, j] = x[k, j] - behind + off * c + swing * s
                state[2, j] = slope - z * w * (off * c + swing * s) + damped * (swing * c - off * s)
            state[0, j] = x[k, j]
            out[k, j] = state[1, j]


@compiled
def delayed(stamp: Array, x: Array, delay: Array, skip: int, out: Array) -> None:
    """``x`` (m, columns) as it was ``delay`` (columns,) s ago, from row ``skip`` on; cubic, using the past alone."""
    rows, columns = x.shape
    for j in range(columns):
        m = 0
        for k in range(skip, rows):
            t = stamp[k] - delay[j]
            if t <= stamp[0] or rows == 1:
                out[k - skip, j] = x[0, j]
                continue
            if delay[j] <= 0.0:
                out[k - skip, j] = x[k, j]
                continue
            while m + 1 < k and stamp[m + 1] < t:
                m += 1
            h = stamp[m + 1] - stamp[m]
            chord = (x[m + 1, j] - x[m, j]) / h
            left = chord
            if m > 0:
                left = (x[m + 1, j] - x[m - 1, j]) / (stamp[m + 1] - stamp[m - 1])
            right = chord
            if m + 2 <= k:
                right = (x[m + 2, j] - x[m, j]) / (stamp[m + 2] - stamp[m])
            s = (t - stamp[m]) / h
            out[k - skip, j] = (
                (1 + 2 * s) * (1 - s) ** 2 * x[m, j] + s * (1 - s) ** 2 * h * left
                + s * s * (3 - 2 * s) * x[m + 1, j] + s * s * (s - 1) * h * right
            )


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
