"""In which state a search stands: what was tried in one that is nearly the same is not tried again."""

from __future__ import annotations

from collections.abc import Hashable, Iterable

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.guards import TINY
from trunk_ros.levels import SLIGHT

State = tuple[Hashable, ...]


def state_of(best: Fit, columns: Iterable[int]) -> State:
    """What a trial on some columns depends on, but for small changes of values and noise."""
    context = best.context
    each = tuple(
        (
            c,
            structure(best.hypothesis, c),
            _level(context.noise[c].std),
            round(context.noise[c].correlation / SLIGHT),
            _level(best.cost[c]) if c in best.cost else 0,
        )
        for c in columns
    )
    return (context.look, context.claims, *each)


def exactly(best: Fit) -> State:
    """What a look or a trial on all joints depends on, to the last digit."""
    context = best.context
    given = tuple((term.effect, term.given) for term in best.hypothesis.values())
    keys = (best.hypothesis.key(c) for c in context.columns)
    return (context.look, context.claims, context.noise, given, *keys)


def structure(hypothesis: Hypothesis, column: int | None = None) -> Hashable:
    """Effects, forms and sources, without values: on a column, or everywhere."""
    if column is None:
        columns = sorted({c for term in hypothesis.values() for c in term.columns})
        return tuple((c, structure(hypothesis, c)) for c in columns)
    return tuple(
        (structure_of(t), tuple(sorted(t.own[column])), tuple(sorted(t.words.get(column, {}).items())))
        for t in hypothesis.on(column)
    )


def structure_of(term: Term) -> Hashable:
    """An effect's form, what its joints share and what is stated of it."""
    return (term.effect, term.form, tuple(sorted(term.shared)), term.given)


def moments_of(hypothesis: Hypothesis) -> frozenset[tuple[str, int | None, str]]:
    """Which effects begin, end or change, on which joints, but for when."""
    return frozenset(
        (name, c, moment)
        for name, term in hypothesis.items()
        for c in (None, *term.own)
        for moment in term.moments(c)
    )


def _level(value: float) -> int:
    return round(float(np.log(max(value, TINY))) / SLIGHT)


def describe(hypothesis: Hypothesis) -> str:
    """One line for logs: effect (form) on joints, counted from 1."""

    def one(term: Term) -> str:
        form = f" ({term.form})" if term.form else ""
        return f"{term.effect}{form} on {', '.join(str(c + 1) for c in term.columns)}".replace("_", " ")

    return "; ".join(one(t) for t in hypothesis.values()) or "nothing"
