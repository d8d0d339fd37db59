"""The friction element of the wire: a play operator, sharp or spread.

``theta[k] = clip(theta[k-1], u[k] - w[k], u[k] + w[k])`` is the paper's deflection against the direction of motion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled


@compiled
def play(u: Array, width: Array, theta: Array, out: Array) -> None:
    """Play of half-width ``width`` (1 or n, columns) over ``u`` (n, columns); ``theta`` (columns,) is the state."""
    steps, columns = u.shape
    varying = width.shape[0] > 1
    for j in range(columns):
        held = theta[j]
        w = width[0, j]
        for k in range(steps):
            if varying:
                w = width[k, j]
            held = min(max(held, u[k, j] - w), u[k, j] + w)
            out[k, j] = held
        theta[j] = held


@compiled
def play_inverse(y: Array, width: Array, theta: Array, u: Array, out: Array) -> None:
    """The input of least motion that takes the play from its state to ``y`` at each step."""
    steps, columns = y.shape
    varying = width.shape[0] > 1
    for j in range(columns):
        for k in range(steps):
            w = width[k, j] if varying else width[0, j]
            if y[k, j] > theta[j]:
                u[j] = y[k, j] + w
            elif y[k, j] < theta[j]:
                u[j] = y[k, j] - w
            else:
                u[j] = min(max(u[j], y[k, j] - w), y[k, j] + w)
            theta[j] = y[k, j]
            out[k, j] = u[j]


class SharpPlay:
    """The nominal friction element."""

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """Pass ``u`` (n, columns) through the play; the memory starts at its centre."""
        theta = u[0].copy() if state is None else state.copy()
        out = np.empty_like(u)
        play(u, np.maximum(width, 0.0), theta, out)
        return out, theta

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """Least motion that gives ``y``; the memory starts at its centre."""
        theta, u = (y[0].copy(), y[0].copy()) if state is None else (state[0].copy(), state[1].copy())
        out = np.empty_like(y)
        play_inverse(y, np.maximum(width, 0.0), theta, u, out)
        return out, (theta, u)
