"""The friction element of the wire: a play operator.

``theta[k] = clip(theta[k-1], u[k] - w[k], u[k] + w[k])`` is the paper's deflection against the direction of
motion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled

JITTER = 1e-9  # rad: a turn below this is rounding, and no reason to cross the dead band


@compiled
def play(x: Array, scale: Array, width: Array, theta: Array, out: Array) -> None:
    """Play of half-width ``width`` (1 or n, columns) over ``scale x`` (n, columns); ``theta`` (columns,) is
    the state.
    """
    steps, columns = x.shape
    varying = width.shape[0] > 1
    for j in range(columns):
        at, w = theta[j], max(width[0, j], 0.0)
        for k in range(steps):
            if varying:
                w = max(width[k, j], 0.0)
            u = x[k, j] * scale[j]
            if at < u - w:  # mostly it stays: a guess at that costs less than to wait for each step
                at = u - w
            elif at > u + w:
                at = u + w
            out[k, j] = at
        theta[j] = at


@compiled
def play_inverse(y: Array, width: Array, theta: Array, u: Array, out: Array) -> None:
    """The input of least motion that takes the play from its state to ``y`` at each step."""
    steps, columns = y.shape
    stride = 1 if width.shape[0] > 1 else 0
    for k in range(steps):
        for j in range(columns):
            w = max(width[k * stride, j], 0.0)
            ahead = y[k, j] - theta[j]
            if ahead > (0.0 if u[j] > theta[j] else JITTER):
                theta[j] = y[k, j]
                u[j] = theta[j] + w
            elif ahead < (0.0 if u[j] < theta[j] else -JITTER):
                theta[j] = y[k, j]
                u[j] = theta[j] - w
            else:
                u[j] = min(max(u[j], theta[j] - w), theta[j] + w)
            out[k, j] = u[j]


class SharpPlay:
    """The nominal friction element."""

    def run(self, u: Array, width: Array, state: Any, scale: Array | None = None) -> tuple[Array, Any]:
        """Pass ``u`` (n, columns), times ``scale`` (columns,), through the play; the memory starts at its
        centre.
        """
        factor = np.ones(u.shape[1]) if scale is None else scale
        theta = u[0] * factor if state is None else state.copy()
        out = np.empty_like(u)
        play(u, factor, width, theta, out)
        return out, theta

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """Least motion that gives ``y``; the memory starts at its centre."""
        theta, u = (y[0].copy(), y[0].copy()) if state is None else (state[0].copy(), state[1].copy())
        out = np.empty_like(y)
        play_inverse(y, width, theta, u, out)
        return out, (theta, u)
