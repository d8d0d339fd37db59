"""How well the data tell the fitted values apart: correlations of their errors, and values at a bound."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Free, bounds
from trunk_ros.diagnosis.search.fit import Fit, groups
from trunk_ros.diagnosis.search.residuals import Residuals
from trunk_ros.effects import effect
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.curve import Curve
from trunk_ros.guards import BLIND, ROUNDED
from trunk_ros.levels import NEARLY, ROUGH
from trunk_ros.units import unit_on


@dataclass(frozen=True)
class Place:
    """A fitted value: ``joint`` is "arm" where all joints share it."""

    effect: str
    parameter: str
    joint: str


@dataclass(frozen=True)
class Correlation:
    """``value`` (-1 to 1) of the errors of two fitted values."""

    first: Place
    second: Place
    value: float


@dataclass(frozen=True)
class AtBound:
    """A value that a fit would move beyond what is believed possible. ``bound`` in ``unit``."""

    place: Place
    side: str
    """``lower`` or ``upper``."""
    bound: float
    unit: str


@dataclass(frozen=True)
class Determined:
    """Of one fit: correlations that are nearly whole, the strongest first, and values at a bound."""

    correlations: list[Correlation] = field(default_factory=list)
    at_bound: list[AtBound] = field(default_factory=list)

    def of(self, effect: str) -> Determined:
        """What is about the values of one effect."""
        return Determined(
            [c for c in self.correlations if effect in (c.first.effect, c.second.effect)],
            [b for b in self.at_bound if b.place.effect == effect],
        )


def determined(state: Fit) -> Determined:
    """Correlations and bounds of all values that a fit moved."""
    correlations: list[Correlation] = []
    at_bound: list[AtBound] = []
    for group in groups(state.context, state.hypothesis):
        residuals = Residuals(state.context, state.hypothesis, group)
        if residuals.free:
            x = np.clip(state.hypothesis.free_values(residuals.free), *bounds(residuals.free))
            slope, normal = residuals.normal(x)
            correlations += _tied(state.context, residuals.free, normal)
            at_bound += _at_bound(state.context, residuals, x, slope)
    return Determined(sorted(correlations, key=lambda c: -abs(c.value)), at_bound)


def correlation(normal: Array) -> Array:
    """(n, n) correlations of the errors of values with the normal matrix (n, n) J^T J; NaN for values that
    the data do not see.
    """
    size = np.sqrt(np.diag(normal))
    seen = size > BLIND
    out = np.full(normal.shape, np.nan)
    scaled = normal[np.ix_(seen, seen)] / np.outer(size[seen], size[seen])
    spread = np.linalg.inv(scaled + ROUNDED * np.eye(len(scaled)))
    std = np.sqrt(np.maximum(np.diag(spread), ROUNDED))
    out[np.ix_(seen, seen)] = np.clip(spread / np.outer(std, std), -1.0, 1.0)
    return out


def _tied(context: Context, free: list[Free], normal: Array) -> list[Correlation]:
    """Between values that mean something each; the weights of a curve do not."""
    told = [k for k, f in enumerate(free) if not issubclass(effect(f.effect), (Bank, Curve))]
    found = correlation(normal)[np.ix_(told, told)]
    free = [free[k] for k in told]
    rows, columns = np.nonzero(np.triu(np.abs(found) >= NEARLY, 1))
    return [
        Correlation(_place(context, free[i]), _place(context, free[j]), float(found[i, j]))
        for i, j in zip(rows, columns, strict=True)
    ]


def _at_bound(context: Context, residuals: Residuals, x: Array, slope: Array) -> list[AtBound]:
    """Values at a bound; those at the value that means "no effect" are where they belong."""
    low, high = bounds(residuals.free)
    out = []
    for k, f in enumerate(residuals.free):
        near = ROUGH * residuals.scale[k]  # not of the range: a moment may be any up to a million seconds
        share = f.parameter.unit == "1" and f.parameter.bounds == (0.0, 1.0)  # all is no more than possible
        if issubclass(effect(f.effect), (Bank, Curve)) or share or f.parameter.periodic:
            continue
        for side, end, beyond in (("lower", 0, slope[k] > 0.0), ("upper", 1, slope[k] < 0.0)):
            bound = f.parameter.bounds[end]
            if beyond and abs(x[k] - (low, high)[end][k]) <= near and bound != f.parameter.null:
                out.append(AtBound(_place(context, f), side, bound, _unit(context, f)))
    return out


def _place(context: Context, f: Free) -> Place:
    return Place(f.effect, f.parameter.name, "arm" if f.column is None else context.joints[f.column])


def _unit(context: Context, f: Free) -> str:
    if f.column is None:
        return f.parameter.unit
    return unit_on(f.parameter, context.stage.unit(f.column))
