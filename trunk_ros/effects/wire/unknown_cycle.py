"""Something that comes back in time, whatever the arm does, and that no name fits."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.curve import KNOTS, Curve

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


class UnknownCycle(Curve):
    """theta += curve(t mod period), period = high - low, t since the start of the recording."""

    id = "unknown_cycle"
    stage = "wire"
    place = 255
    linear = True
    signature = "The residual swings in time with one period, whether the joint moves or not."
    of = "the angle, again and again,"
    swings: ClassVar[str] = "the angle swings with {}"
    whenever: ClassVar[str] = ", whether the joint moves or not"
    # A live run does not begin at the phase of the recording: with another phase it would get worse.
    compensable = False
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = (
        ("link_resonance", "stand still: a resonance dies out, what shakes the arm goes on"),
    )

    @classmethod
    def onto(cls, x: Array, low: Array, high: Array) -> Array:
        period = np.where(high > low, high - low, 1.0)
        return np.asarray(x - np.floor((x - low) / period) * period)

    @classmethod
    def spline(cls, knots: Array, values: Array) -> CubicSpline:
        from scipy.interpolate import CubicSpline

        return CubicSpline(knots, np.concatenate([values[:-1], values[:1]]), bc_type="periodic")

    @classmethod
    def bend(cls) -> Array:
        turn = np.eye(KNOTS - 1)
        second = np.roll(turn, 1, 1) + np.roll(turn, -1, 1) - 2 * turn
        return np.pad(second, ((0, 0), (0, 1)))
