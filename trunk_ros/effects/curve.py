"""A smooth curve over something that is measured."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.effect import Effect, Now, Regime
from trunk_ros.errors import ModelError
from trunk_ros.parameter import Parameter

KNOTS = 24
VARIABLES = ("position", "speed", "time", "load")
RANGE = (
    Parameter("low", "1", (-1e9, 1e9), "where the curve begins", typical=-1.0),
    Parameter("high", "1", (-1e9, 1e9), "where the curve ends", typical=1.0),
)
VALUES = tuple(
    Parameter(f"value_{k:02d}", "rad", (-10.0, 10.0), "the curve at an evenly spaced knot", typical=1e-3)
    for k in range(KNOTS)
)


class Curve(Effect):
    """+= curve(x), x being position (ratio phi), speed, time, load or another joint's angle, held beyond
    its ends.
    """

    signature = "The residual depends on something in a way that no named effect has."
    source = "Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63(3): a discrepancy term beside the physics."
    named = False
    regime: ClassVar[Regime] = "posture"
    parameters = RANGE + VALUES
    texts = ("on",)
    of: ClassVar[str] = "the angle"
    """What the curve is added to."""
    also: ClassVar[tuple[str, ...]] = ()
    """What the change depends on besides."""

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._curve(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._curve(now), None

    def check(self, joints: tuple[str, ...]) -> None:
        super().check(joints)
        for column, variable in enumerate(self.words.get("on", ())):
            if variable and variable not in (*VARIABLES, *joints):
                raise ModelError(
                    f"effects.{self.id}.on = {variable!r}: choose from {', '.join((*VARIABLES, *joints))}"
                )
            if variable and not self["low"][column] < self["high"][column]:
                raise ModelError(f"effects.{self.id} of {joints[column]}: low must be below high")

    def _curve(self, now: Now) -> Array:
        first, *others = self._columns or [("time", np.ones(1, dtype=bool))]
        x = np.ascontiguousarray(abscissae(first[0], now))
        for variable, here in others:
            x = np.where(here, abscissae(variable, now), x)
        out = np.zeros(x.shape)
        curves(x, self["low"], self["high"], self._pieces, out)
        return out

    @cached_property
    def _columns(self) -> list[tuple[str, np.ndarray]]:
        """What the curves are over, and (columns,) whose are."""
        words = self.words.get("on", ())
        return [(variable, np.array([word == variable for word in words])) for variable in {*words} - {""}]

    @cached_property
    def _pieces(self) -> Array:
        """(columns, 4, KNOTS - 1) cubics between the knots, highest power first; zeros where there is no
        curve.
        """
        words = self.words.get("on", ())
        pieces = np.zeros((len(self["low"]), 4, KNOTS - 1))
        for column, variable in enumerate(words):
            if variable:
                knots = np.linspace(self["low"][column], self["high"][column], KNOTS)
                pieces[column] = CubicSpline(
                    knots, [self[p.name][column] for p in VALUES], bc_type="natural"
                ).c
        return pieces


@compiled
def curves(x: Array, low: Array, high: Array, pieces: Array, out: Array) -> None:
    """Natural cubic splines over ``x`` (n, columns), held beyond their ends."""
    for j in range(x.shape[1]):
        width = (high[j] - low[j]) / pieces.shape[2]
        if width <= 0.0:
            continue
        for k in range(x.shape[0]):
            along = min(max(x[k, j], low[j]), high[j]) - low[j]
            i = min(int(along / width), pieces.shape[2] - 1)
            t = along - i * width
            out[k, j] = ((pieces[j, 0, i] * t + pieces[j, 1, i]) * t + pieces[j, 2, i]) * t + pieces[j, 3, i]


def abscissae(variable: str, now: Now) -> Array:
    """(n, columns) what a curve is drawn over, in SI units."""
    if variable == "position":
        return np.asarray(now.gearbox * now.ratio)
    if variable == "speed":
        return now.speed
    if variable == "load":
        return now.load
    one = now.stamp if variable == "time" else now.angles[:, now.joints.index(variable)]
    return np.broadcast_to(one[:, None], (len(one), len(now.ratio)))


def abscissa(variable: str, now: Now, column: int) -> Array:
    """(n,) what the curve of one column is drawn over, in SI units."""
    return np.asarray(abscissae(variable, now)[:, column])
