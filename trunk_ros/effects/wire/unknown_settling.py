"""Loops that are others at first, and settle as the joint slides."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.drags import WIDEST
from trunk_ros.effects.postures import LEAST, OverPostures, parameters_over_postures

LENGTH = 1.3  # ranges slid until a third is left: shares of several would cancel only where they were seen
GRIP = 0.2  # of the range, within which a joint does not slide


class UnknownSettling(OverPostures):
    """theta += exp(-slid / length) (a + b u + c (3 u^2 - 1) / 2 + d (s - play(s, reach)) / reach), s = r phi
    of the joint itself, or the angle that the effects before it give, where neighbours drag the joint along.

    u goes from -1 to 1 over the range of s, constant beyond; reach is 0.4 of that range, length 1.3 times
    it; slid is the path since the start of a play of half that reach. What a wire rubs on runs in, and its
    strands take their places: each swing differs less from the one before.
    """

    id = "unknown_settling"
    place = 243
    signature = "The residual is a loop that is another one at first, and differs less from swing to swing."
    source = (
        "Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63(3): a discrepancy term beside the physics; "
        "running in: Blau (2005), Tribol. Int. 38(11)."
    )
    fades = True
    groups = (3, 1)
    weights = sum(groups)
    parameters = parameters_over_postures(weights, typical=2e-4)
    confused_with = (
        ("thermal_drift", "let the joint rest: only a drift goes on"),
        ("friction_wear", "start again after a rest: wear stays"),
    )

    @classmethod
    def ready(cls, low: float, high: float, weights: Array) -> tuple[float, float, Array]:
        return low, max(high, low + LEAST), weights

    @classmethod
    def add(cls, s: Array, ready: tuple[float, float, Array], state: Any, out: Array) -> Array:
        low, high, weights = ready
        state = np.array([s[0], s[0], 0.0] if state is None else state)
        shapes = np.empty((len(weights), len(s)))
        settling(s, low, high, state, shapes)
        out += weights @ shapes
        return np.asarray(state)

    @classmethod
    def steepness(cls, low: float, high: float, weights: Array) -> float:
        """Of all shapes at the start, where they are largest, and of their fading."""
        slopes = np.array([0.0, 2.0, 6.0, 1.0 / WIDEST]) + 1.0 / LENGTH
        return float(np.abs(weights) @ slopes) / max(high - low, LEAST)


@compiled
def settling(s: Array, low: float, high: float, state: Array, out: Array) -> None:
    """Write into ``out`` (4, n) what fades of ``s`` (n,); ``state``, where its two plays are and how far the
    narrower one has slid, changes in place.
    """
    size = high - low
    grip, reach = GRIP * size, WIDEST * size
    for i in range(len(s)):
        u = min(max(2.0 * (s[i] - low) / size - 1.0, -1.0), 1.0)
        state[0] = min(max(state[0], s[i] - reach), s[i] + reach)
        at = min(max(state[1], s[i] - grip), s[i] + grip)
        state[2] += abs(at - state[1])
        state[1] = at
        left = np.exp(-state[2] / (LENGTH * size))
        out[0, i] = left
        out[1, i] = left * u
        out[2, i] = left * (1.5 * u * u - 0.5)
        out[3, i] = left * (s[i] - state[0]) / reach
