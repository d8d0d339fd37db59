"""A joint's values of an effect begun from those of the joint that shows it most: joints of one arm are much
alike, and what one hardly tells may have several minima.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.levels import SEVERAL
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, change, refit_column
from trunk_ros.diagnosis.search.state import structure_of
from trunk_ros.effects import effect


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint of an effect that has several values of each, which nobody states."""
    for name, term in best.hypothesis.items():
        kind, columns = effect(name), best.context.judged(term)
        own = [p.name for p in kind.own_parameters(term.form) if not p.shared and p.name not in term.given]
        if kind.named and min(len(own), len(columns)) >= SEVERAL and not kind.texts:
            surest = cache(partial(_surest, best, name, columns))
            for column in columns:
                what = (name, structure_of(term), column)
                yield Group(what, [column], partial(_like_it, best, name, own, column, surest))


def _surest(best: Fit, name: str, columns: list[int]) -> int:
    """The joint on which an effect changes most, over the noise."""
    less = best.hypothesis.without(name)
    changes = {c: change(best.context, best.hypothesis, less, c) for c in columns}
    return max(columns, key=lambda c: float(changes[c] @ changes[c]))


def _like_it(best: Fit, name: str, names: list[str], column: int, surest: Callable[[], int]) -> Iterator[Fit]:
    unit = best.context.stage.unit
    if surest() != column and unit(surest()) == unit(column):
        yield refit_column(best, _with_values_of(best.hypothesis, name, names, column, surest()), column)


def _with_values_of(now: Hypothesis, name: str, names: list[str], column: int, other: int) -> Hypothesis:
    out = now.copy()
    own, theirs = out[name].own[column], out[name].own[other]
    out[name].own[column] = own | {n: theirs[n] for n in names if n in own and n in theirs}
    return out


LIKE = Move("like", groups, resort=True)
