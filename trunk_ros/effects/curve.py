"""A smooth curve over something that is measured."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.effect import Effect, Now, Regime
from trunk_ros.errors import ModelError
from trunk_ros.parameter import ANY, Parameter

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

KNOTS = 24
VARIABLES = ("position", "speed", "time", "load")
SPEED_OF = "speed of "
HALF, OVER_TIME = 0.5, 0.15  # of a misfit that a curve may leave
REACH = 0.5  # of its range that a curve goes on straight beyond its ends
FAR = 3.0  # the same of a straight line
STRAIGHT = 0.01  # of its rise: what leaves the line between its ends by no more is one
RANGE = (
    Parameter("low", "1", (-1e9, 1e9), "where the curve begins", typical=-1.0),
    Parameter("high", "1", (-1e9, 1e9), "where the curve ends", typical=1.0),
)
LOW, HIGH = (p.name for p in RANGE)
ON = "on"  # the word that says what a curve is over
VALUES = tuple(
    Parameter(f"value_{k:02d}", "rad", ANY, "the curve at an evenly spaced knot", typical=1e-3)
    for k in range(KNOTS)
)


class Curve(Effect):
    """+= curve(x), x being position (ratio phi), speed, time, load, another joint's angle or its speed.
    Outside the observed range a curve is extrapolated linearly, by half its range (three ranges for straight
    lines); the wavier it is the less, and the more it goes back to its mean. Curves over time are held.
    """

    signature = "The residual depends on something in a way that no named effect has."
    source = "Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63(3): a discrepancy term beside the physics."
    named = False
    regime: ClassVar[Regime] = "posture"
    parameters = RANGE + VALUES
    texts = (ON,)
    follows_readings: ClassVar[bool] = False
    """Over time it adds to the angle whatever there is, as a reading that wanders does."""
    linear: ClassVar[bool] = False
    """It is added to the angle, times its ``factor``."""
    hides: ClassVar[bool] = False
    """A small one shows nothing of a large one: a fit begins at the best constant."""
    ahead: ClassVar[bool] = False
    """It is added to what the core is handed, which lets less of it through."""
    of: ClassVar[str] = "the angle"
    """What the curve is added to."""
    also: ClassVar[tuple[str, ...]] = ()
    """What the change depends on besides."""

    @classmethod
    def factor(cls, now: Now) -> Array:
        """What the curve is multiplied by before it is added to the angle; it broadcasts to (n, columns)."""
        return np.ones(1)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self.factor(now) * self._curve(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self.factor(now) * self._curve(now), None

    def check(self, joints: tuple[str, ...]) -> None:
        super().check(joints)
        for column, variable in enumerate(self.words.get("on", ())):
            if variable and variable.removeprefix(SPEED_OF) not in (*VARIABLES, *joints):
                raise ModelError(
                    f"effects.{self.id}.on = {variable!r}: choose from {', '.join((*VARIABLES, *joints))}"
                    f" or {SPEED_OF}{joints[0]} …"
                )
            if variable and not self["low"][column] < self["high"][column]:
                raise ModelError(f"effects.{self.id} of {joints[column]}: low must be below high")

    def _curve(self, now: Now) -> Array:
        first, *others = self._columns or [("time", np.ones(1, dtype=bool))]
        x = np.ascontiguousarray(abscissae(first[0], now))
        for variable, here in others:
            x = np.where(here, abscissae(variable, now), x)
        out = np.zeros(x.shape)
        low, high = self["low"], self["high"]
        curves(self.onto(x, low, high), low, high, self._beyond, self._pieces, out)
        return out

    @classmethod
    def onto(cls, x: Array, low: Array, high: Array) -> Array:
        """Where on a curve from ``low`` to ``high`` (columns,) each ``x`` (n, columns) lies."""
        return x

    @classmethod
    def spline(cls, knots: Array, values: Array) -> CubicSpline:
        """The curve through ``values`` (KNOTS, ...) at ``knots`` (KNOTS,)."""
        from scipy.interpolate import CubicSpline  # of few models: importing it takes a node 0.3 s

        return CubicSpline(knots, values, bc_type="natural")

    @classmethod
    def over(cls, variables: list[str], own: list[str]) -> list[str]:
        """What it is tried over, of what there is: all ``variables``, and those that are the joint's own."""
        return []

    @classmethod
    def leaves(cls, words: Mapping[str, str]) -> float:
        """Share of a misfit from which on a curve with these words is over something else than what is at
        work; what moves slowly is imitated by any curve over time.
        """
        return OVER_TIME if "time" in words.values() else HALF

    @classmethod
    def bend(cls) -> Array:
        """(k, KNOTS) second differences of the values."""
        return np.diff(np.eye(KNOTS), 2, axis=0)

    @classmethod
    def basis(cls, x: Array, low: float, high: float) -> Array:
        """(n, KNOTS) the curve at ``x`` (n,) per value."""
        spline = cls.spline(np.linspace(low, high, KNOTS), np.eye(KNOTS))
        return np.asarray(spline(cls.onto(x, np.asarray(low), np.asarray(high))))

    @cached_property
    def _beyond(self) -> Array:
        """(3, 2, columns) beyond the lower and the upper end of each curve: how far it goes on, of its range;
        by which share it goes back meanwhile, as waves do; and to where, the mean of that half of the curve.
        """
        values = np.array([self[p.name] for p in VALUES])
        line = np.linspace(values[0], values[-1], KNOTS)
        straight = np.abs(values - line).max(axis=0) <= STRAIGHT * np.ptp(values, axis=0)
        halves = values[: KNOTS // 2 + 1], values[-(KNOTS // 2 + 1) :]
        direct = np.array([directness(half) for half in halves])
        timed = np.array([word in ("time", "") for word in self.words.get("on", ("",) * values.shape[1])])
        far = np.where(timed, 0.0, np.where(straight, FAR, REACH * direct))
        back = np.where(timed | straight, 0.0, (1.0 - direct) ** 2)  # a little noise bends no curve back
        return np.array([far, back, [values.mean(axis=0)] * 2])

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
        low, high, values = self["low"], self["high"], np.array([self[p.name] for p in VALUES])
        pieces = np.zeros((len(low), 4, KNOTS - 1))
        ends: dict[tuple[float, float], list[int]] = {}
        for column, variable in enumerate(words):
            if variable:
                ends.setdefault((low[column], high[column]), []).append(column)
        for (first, last), some in ends.items():
            powers = ((KNOTS - 1) / (last - first)) ** np.arange(3, -1, -1)
            drawn = np.tensordot(unit_pieces(type(self)), values[:, some], 1)
            pieces[some] = np.moveaxis(drawn, 2, 0) * powers[:, None]
        return pieces


@cache
def unit_pieces(kind: type[Curve]) -> Array:
    """(4, KNOTS - 1, KNOTS) cubics between knots one apart, highest power first, per value."""
    return np.asarray(kind.spline(np.arange(KNOTS, dtype=float), np.eye(KNOTS)).c)


@compiled
def curves(x: Array, low: Array, high: Array, beyond: Array, pieces: Array, out: Array) -> None:
    """Cubic splines over ``x`` (n, columns), and what they are ``beyond`` (3, 2, columns) their lower and
    upper ends: straight for so much of their range, and on the way back by a share towards a value.
    """
    last = pieces.shape[2] - 1
    for j in range(x.shape[1]):
        width = (high[j] - low[j]) / (last + 1)
        if width <= 0.0:
            continue
        reach = beyond[0, :, j] * (high[j] - low[j])
        for k in range(x.shape[0]):
            there = min(max(x[k, j], low[j] - reach[0]), high[j] + reach[1])
            along = min(max(there, low[j]), high[j]) - low[j]
            i = min(int(along / width), last)
            t = along - i * width
            a, b, c, d = pieces[j, 0, i], pieces[j, 1, i], pieces[j, 2, i], pieces[j, 3, i]
            value = ((a * t + b) * t + c) * t + d
            off = there - low[j] - along
            if off != 0.0:
                end = 1 if off > 0.0 else 0
                back = beyond[1, end, j] * abs(off) / reach[end]
                straight = value + ((3.0 * a * t + 2.0 * b) * t + c) * off
                value = straight + back * (beyond[2, end, j] - straight)
            out[k, j] = value


def directness(values: Array) -> Array:
    """(columns,) net change of curves (k, columns) over the way that they went up and down."""
    way = np.abs(np.diff(values, axis=0)).sum(axis=0)
    return np.asarray(np.abs(values[-1] - values[0]) / np.where(way > 0.0, way, 1.0))


def words_of(variable: str) -> list[str]:
    """What a variable is made of, such as a joint and its speed."""
    joint = variable.removeprefix(SPEED_OF)
    return [variable] if joint == variable else [joint, "speed"]


def abscissae(variable: str, now: Now) -> Array:
    """(n, columns) what a curve is drawn over, in SI units."""
    if variable == "position":
        return np.asarray(now.gearbox * now.ratio)
    if variable == "speed":
        return now.speed
    if variable == "load":
        return now.load
    if variable.startswith(SPEED_OF):
        one = now.speed_of(now.joints.index(variable.removeprefix(SPEED_OF)))
    else:
        one = now.stamp if variable == "time" else now.angles[:, now.joints.index(variable)]
    return np.broadcast_to(one[:, None], (len(one), len(now.ratio)))


def abscissa(variable: str, now: Now, column: int) -> Array:
    """(n,) what the curve of one column is drawn over, in SI units."""
    return np.asarray(abscissae(variable, now)[:, column])
