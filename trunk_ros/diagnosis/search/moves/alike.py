"""All that another joint has in the place of all that a joint has: joints of one arm are much alike, and from
a wrong pair of effects no exchange of one leads to the right pair.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from trunk_ros.diagnosis.search.candidates import own_effects
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.trial import refit_column_to_win
from trunk_ros.effects import effect
from trunk_ros.levels import SEVERAL


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each joint, by the joints that differ from it by more than one effect for another."""
    theirs = {c: _of_its_own(best, c) for c in best.context.columns}
    for column, mine in theirs.items():
        others = {
            names: c
            for c, names in theirs.items()
            if mine and len(names ^ mine) > SEVERAL and _may_be_its_own(best, names, c, column)
        }
        if others:
            yield Group(column, [column, *others.values()], partial(_alike, best, column, others))


def _of_its_own(best: Fit, column: int) -> frozenset[str]:
    known = best.context.known
    there = own_effects(best.hypothesis, column)
    return frozenset(name for name in there if name not in known or column not in known[name].own)


def _may_be_its_own(best: Fit, names: frozenset[str], other: int, column: int) -> bool:
    """Whether a joint can have what another one has: names, in its unit, of which it is not itself the
    source.
    """
    unit, joint = best.context.stage.unit, best.context.joints[column]
    words = [word for name in names for word in best.hypothesis.get_words(name, other)]
    named = bool(names) and all(effect(name).named for name in names)
    return named and unit(other) == unit(column) and joint not in words


def _alike(best: Fit, column: int, others: dict[frozenset[str], int]) -> Iterator[Fit]:
    mine = _of_its_own(best, column)
    for names, other in others.items():
        out = best.hypothesis.less(mine, column)
        for name in sorted(names):
            term = best.hypothesis[name]
            words = {column: term.words[other]} if other in term.words else {}
            out.have(column, replace(term, own={column: term.own[other]}, words=words))
        yield refit_column_to_win(best, out, column)


ALIKE = Move("alike", groups, resort=True)
