"""Physics that no name fits: a smooth curve over what it was seen to depend on."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter

KNOTS = 24
RANGE = (Parameter("low", "1", (-1e9, 1e9), "where the curve begins", typical=-1.0),
         Parameter("high", "1", (-1e9, 1e9), "where the curve ends", typical=1.0))
VALUES = tuple(Parameter(f"value_{k:02d}", "rad", (-10.0, 10.0), "the curve at an evenly spaced knot", typical=1e-3)
               for k in range(KNOTS))


class Unknown(Effect):
    """theta += curve(x), x being position (ratio phi), speed, time, load or another joint's angle, held beyond its ends."""

    id = "unknown"
    stage, place, regime = "wire", 250, "posture"
    signature = "The residual depends on something in a way that no named effect has."
    source = "Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63(3): a discrepancy term beside the physics."
    parameters = RANGE + VALUES
    texts = ("on",)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._curve(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._curve(now), None

    def _curve(self, now: Now) -> Array:
        added = np.zeros_like(now.gearbox)
        for column, variable in enumerate(self.words.get("on", ())):
            if variable:
                knots = np.linspace(self["low"][column], self["high"][column], KNOTS)
                curve = CubicSpline(knots, [self[p.name][column] for p in VALUES], bc_type="natural")
                added[:, column] = curve(np.clip(abscissa(variable, now, column), knots[0], knots[-1]))
        return added


def abscissa(variable: str, now: Now, column: int) -> Array:
    """(n,) what a curve is drawn over, in SI units."""
    if variable == "position":
        return now.gearbox[:, column] * now.ratio[column]
    if variable == "time":
        return now.stamp
    if variable == "speed":
        return now.speed[:, column]
    if variable == "load":
        return now.load[:, column]
    return now.angles[:, now.joints.index(variable)]
