"""What ``diagnosis.json`` says of a curve without a name."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from trunk_ros.data.spectrum import repeats_in
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Term
from trunk_ros.effects.curve import HIGH, KNOTS, LOW, ON, SPEED_OF, VALUES, Curve, words_of
from trunk_ros.effects.wire.unknown_cycle import UnknownCycle
from trunk_ros.effects.wire.unknown_jumps import MOMENTS, UnknownJumps
from trunk_ros.units import unit_of, unit_on

REGIME_OF = {
    "position": "posture",
    "load": "posture",
    "speed": "high_speed",
    "time": "time",
    "direction": "reversal",
}


def by_variable(context: Context, term: Term) -> list[Term]:
    """A curve over time and one over position are two findings, and so are those of a slide and of a joint
    that turns.
    """
    over: dict[tuple[str, str], list[int]] = {}
    for column in term.columns:
        over.setdefault((variable_of(term, column), context.stage.unit(column)), []).append(column)
    return [
        replace(term, own={c: term.own[c] for c in columns}, words={c: term.words[c] for c in columns})
        for columns in over.values()
    ]


def variable_of(term: Term, column: int) -> str:
    """What a column's curve is drawn over."""
    return term.words[column][ON]


def regime_of(kind: type[Curve], variable: str) -> str:
    """When a curve matters."""
    if kind.regime != "posture":
        return kind.regime
    return REGIME_OF.get(words_of(variable)[-1], "posture")


def statement(context: Context, kind: type[Curve], term: Term, where: str) -> str:
    """One sentence; of what swings as the motion does, two."""
    if issubclass(kind, UnknownCycle):
        rates = {f"{1.0 / term.own[c][HIGH]:.3g} Hz" for c in term.columns}
        swings = kind.swings.format(" and ".join(sorted(rates)))
        stands_in = "in a way that no name fits; a smooth curve over one period stands in for it."
        if not any(_moves_alike(context, c, term.own[c][HIGH]) for c in term.columns):
            return f"{where}: {swings}{kind.whenever}, {stands_in}"
        return (
            f"{where}: {swings}, as often as the motion repeats, {stands_in} These data do not show whether "
            "it comes with time or with the motion: record a motion that does not repeat."
        )
    if issubclass(kind, UnknownJumps):
        count = max(sum(p.name in term.own[c] for p in MOMENTS) for c in term.columns)
        return f"{where}: the zero jumps {count} times, which no name fits; levels stand in for it."
    of = f"{kind.of} " if kind.of != Curve.of else ""
    on = variable_of(term, term.columns[0])
    return f"{where}: {of}depends on {on} in a way that no name fits; a smooth curve stands in for it."


def _moves_alike(context: Context, column: int, period: float) -> bool:
    """Whether a motor repeats its motion as often as a column's residual swings."""
    span = context.views[context.telling(column)[0]].span
    return repeats_in(span.measured(span.source), span.stamp, period, KNOTS)


def told(context: Context, kind: type[Curve], term: Term) -> dict[str, Any]:
    """The curves by joint, with what they are over and of, and their units."""
    variable = variable_of(term, term.columns[0])
    own = context.stage.unit(term.columns[0])
    other = variable.removeprefix(SPEED_OF)
    over = context.stage.units.get(other, "rad") if other in context.joints else own
    slope = "/s" if "speed" in words_of(variable) else ""
    return {
        "on": variable,
        "of": kind.of,
        "x_unit": {"time": "s", "load": unit_of("N*m", own)}.get(variable, over + slope),
        "y_unit": unit_on(kind.parameter(VALUES[0].name), own),
        "joints": {context.joints[c]: _points(kind, term.own[c]) for c in term.columns},
    }


def _points(kind: type[Curve], values: dict[str, float]) -> dict[str, Any]:
    low, high = values[LOW], values[HIGH]
    if issubclass(kind, UnknownJumps):
        at = [low, *(values[p.name] for p in MOMENTS if p.name in values)]
        return {"x": np.array(at), "y": np.array([values[p.name] for p in VALUES[: len(at)]])}
    x = np.linspace(low, high, KNOTS)
    return {"x": x, "y": kind.basis(x, low, high) @ np.array([values[p.name] for p in VALUES])}
