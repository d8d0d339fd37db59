"""Which joints an effect is on that acts on all, and from where their own values are fitted; one whose
size they share is left by none.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import taken
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, costed_on, refit_column
from trunk_ros.diagnosis.search.state import structure_of
from trunk_ros.diagnosis.search.trial import begun_on
from trunk_ros.effects import effect
from trunk_ros.parameter import leading


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint by itself."""
    for name in [name for name in best.hypothesis if effect(name).everywhere]:
        term = best.hypothesis[name]
        alike = leading(effect(name).own_parameters(term.form)).shared
        for column in best.context.columns:
            change = joined if column not in term.columns else None if alike else left
            if change is not None:
                what = (name, structure_of(term), column)
                yield Group(what, [column], partial(change, best, name, column))


def left(now: Fit, name: str, column: int) -> Iterator[Fit]:
    """Without an effect on one of its joints; where more than noise is left there, also with it begun anew: a
    value that was led to where it changes nothing does not find back.
    """
    if len(now.hypothesis[name].columns) == 1:
        return
    yield refit_column(now, now.hypothesis.without(name, column), column)
    if now.beyond_noise(column) > 0.0:
        begun = [costed_on(now, there, column) for there in _anew(now, name, column)]
        if begun:
            yield refit_column(now, min(begun, key=lambda fit: fit.total).hypothesis, column)


def _anew(now: Fit, name: str, column: int) -> Iterator[Hypothesis]:
    """With the first of a joint's own values at each of its starts."""
    form = now.hypothesis[name].form
    lead = effect(name).own_parameters(form)[0].name
    for start in effect(name)({}, {}, form).starts(now.context.shown(column), 0):
        if lead in now.hypothesis[name].own[column]:
            there = now.hypothesis.copy()
            there[name].own[column][lead] = start[lead]
            yield there


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
