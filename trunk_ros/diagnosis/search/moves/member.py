"""Which joints an effect is on that acts on all; one without values of a joint's own is left by none."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import taken
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.state import structure_of
from trunk_ros.diagnosis.search.trial import begun_on
from trunk_ros.effects import effect


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint by itself."""
    for name in [name for name in best.hypothesis if effect(name).everywhere]:
        term = best.hypothesis[name]
        alike = all(p.shared for p in effect(name).own_parameters(term.form))
        for column in best.context.columns:
            change = joined if column not in term.columns else None if alike else left
            if change is not None:
                what = (name, structure_of(term), column)
                yield Group(what, [column], partial(change, best, name, column))


def left(now: Fit, name: str, column: int) -> Iterator[Fit]:
    """Without an effect on one of its joints."""
    if len(now.hypothesis[name].columns) > 1:
        yield refit_column(now, now.hypothesis.without(name, column), column)


def joined(now: Fit, name: str, column: int) -> Iterator[Fit]:
    """With an effect on a further joint."""
    with_it = _joined(now, name, column)
    if with_it is not None:
        yield refit_column(now, with_it, column)


def _joined(now: Fit, name: str, column: int) -> Hypothesis | None:
    kind, form, out = effect(name), now.hypothesis[name].form, now.hypothesis.copy()
    if all(p.shared for p in kind.own_parameters(form)):
        out[name].own[column] = {}
        return out
    if taken(kind, out, column):
        return None
    return begun_on(now.context, now.hypothesis, kind, form, [column])


MEMBER = Move("member", groups, cheap=True)
