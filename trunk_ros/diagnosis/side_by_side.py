"""Hypotheses that differ in values alone, computed at once: each is a column of the same blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis, Term, payload_of
from trunk_ros.effects import Effect, effect


def alike(hypotheses: Sequence[Hypothesis]) -> Iterator[list[int]]:
    """Places of hypotheses in a row by which the arm carries the same."""
    for _, same in groupby(range(len(hypotheses)), lambda k: payload_of(hypotheses[k])):
        yield list(same)


def bind_together(hypotheses: Sequence[Hypothesis], column: int) -> list[Effect] | None:
    """The effects that hypotheses have on one joint, as blocks over as many columns; None where they differ
    in more than values and words, or what an effect does on one column depends on the others.
    """
    terms = list(zip(*(h.on(column) for h in hypotheses), strict=False))
    alike = len({len(h.on(column)) for h in hypotheses}) == 1 and len(set(map(payload_of, hypotheses))) == 1
    if not alike or any(len({_kind_on(t, column) for t in same}) > 1 for same in terms):
        return None
    if any(same[0].form in effect(same[0].effect).shaking for same in terms):
        return None
    return [_side_by_side(same, column) for same in terms]


def _kind_on(term: Term, column: int) -> tuple[object, ...]:
    """What terms have to have in common to be blocks of one array."""
    words = term.words.get(column, {})
    return (term.effect, term.form, *term.shared, None, *term.own[column], None, *words)


def _side_by_side(terms: Sequence[Term], column: int) -> Effect:
    kind = effect(terms[0].effect)
    values = [{**kind.null(), **term.values(column)} for term in terms]
    words = [term.words.get(column, {}) for term in terms]
    numbers = {name: np.array([each[name] for each in values]) for name in values[0]}
    return kind(numbers, {w: tuple(each[w] for each in words) for w in words[0]}, terms[0].form)
