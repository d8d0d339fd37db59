"""A joint's values of an effect begun from those of the joint that tells it best: joints of one arm are much
alike, and what one hardly tells may have several minima.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.levels import SEVERAL
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, change, refit_column
from trunk_ros.diagnosis.search.state import structure_of
from trunk_ros.effects import effect


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint of an effect that has several values of each."""
    for name, term in best.hypothesis.items():
        columns = [c for c in term.columns if c in best.context.columns]
        own = [p for p in effect(name).own_parameters(term.form) if not p.shared]
        if effect(name).named and min(len(own), len(columns)) >= SEVERAL and not effect(name).texts:
            for column in columns:
                what = (name, structure_of(term), column)
                yield Group(what, [column], partial(_like_the_surest, best, name, column))


def _like_the_surest(best: Fit, name: str, column: int) -> Iterator[Fit]:
    context, less = best.context, best.hypothesis.without(name)
    others = [c for c in best.hypothesis[name].columns if c in context.columns and c != column]
    surest = max(others, key=lambda c: float((d := change(context, best.hypothesis, less, c)) @ d))
    there = best.hypothesis.copy()
    own, theirs = there[name].own[column], there[name].own[surest]
    moments = {m.name for m in effect(name).moments()}
    there[name].own[column] = own | {n: v for n, v in theirs.items() if n in own and n not in moments}
    yield refit_column(best, there, column)


LIKE = Move("like", groups, resort=True)
