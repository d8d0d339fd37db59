"""Hypotheses that differ in values alone, computed at once: each is a column of the same blocks."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis, Term, payload_of
from trunk_ros.effects import Effect, effect

Seen = tuple[Hypothesis, int]
"""A hypothesis, and the joint that it predicts."""


def alike(pairs: Sequence[Seen], joint_by_joint: bool) -> Iterator[list[int]]:
    """Places of those that differ in values and words alone, and by which the arm carries the same."""
    if len(pairs) == 1:
        return iter([[0]])
    found: dict[Hashable, list[int]] = {}
    for k, (hypothesis, column) in enumerate(pairs):
        terms = hypothesis.on(column)
        which = column if joint_by_joint else -1
        kinds = tuple(_kind_on(term, column) for term in terms)
        found.setdefault((payload_of(hypothesis), which, kinds), []).append(k)
    return iter(found.values())


def bind_together(pairs: Sequence[Seen]) -> list[Effect]:
    """The effects that hypotheses which are ``alike`` have on their joints, as blocks of as many columns."""
    columns = [column for _, column in pairs]
    terms = zip(*(hypothesis.on(column) for hypothesis, column in pairs), strict=True)
    return [_side_by_side(same, columns) for same in terms]


def _kind_on(term: Term, column: int) -> tuple[object, ...]:
    """What terms have to have in common to be blocks of one array."""
    words = term.words.get(column, {})
    return (term.effect, term.form, *term.shared, None, *term.own[column], None, *words)


def _side_by_side(terms: Sequence[Term], columns: Sequence[int]) -> Effect:
    kind = effect(terms[0].effect)
    seen = list(zip(terms, columns, strict=True))
    values = [{**kind.null(), **term.values(column)} for term, column in seen]
    words = [term.words.get(column, {}) for term, column in seen]
    numbers = {name: np.array([each[name] for each in values]) for name in values[0]}
    return kind(numbers, {w: tuple(each[w] for each in words) for w in words[0]}, terms[0].form)
