"""A joint that follows several others: any one source less, or another effect in its place."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import extended, open_kinds
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, refit_column
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.effects import effect
from trunk_ros.levels import REFITTED


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint with several sources."""
    for name, term in best.hypothesis.items():
        for column in best.context.judged(term) if effect(name).named else []:
            if len(best.hypothesis.get_words(name, column)) > 1:
                yield Group((name, column), [column], partial(_fewer, best, name, column))


def _fewer(now: Fit, name: str, column: int) -> Iterator[Fit]:
    for gone in range(len(now.hypothesis.get_words(name, column))):
        less = refit_column(now, without_source(now.hypothesis, name, column, gone), column)
        yield less
        screen = Screen(now.context, less.hypothesis, [column])
        kinds = [k for k in open_kinds(now.context, less.hypothesis, column) if k.id != name]
        for candidate in screen.ranked(kinds, column, REFITTED):
            yield refit_column(now, extended(now.context, less.hypothesis, candidate), column)


def without_source(hypothesis: Hypothesis, name: str, column: int, gone: int) -> Hypothesis:
    """Without one of a joint's sources; those after it move up."""
    out, kind = hypothesis.copy(), effect(name)
    term = out[name]
    words, own = list(term.words[column].values()), term.own[column]
    gains = [own.pop(kind.parameters[k].name) for k in range(len(words))]
    left = [k for k in range(len(words)) if k != gone]
    term.words[column] = {kind.texts[new]: words[old] for new, old in enumerate(left)}
    own |= {kind.parameters[new].name: gains[old] for new, old in enumerate(left)}
    return out


SOURCE = Move("source", groups)
