"""One effect in the place of one or two of a joint's."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import combinations

from trunk_ros.diagnosis.search.candidates import open_kinds, own_effects
from trunk_ros.diagnosis.search.descent import Desk, Group, Move, descend_with, only
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.moves.form import FORM
from trunk_ros.diagnosis.search.score import need, score
from trunk_ros.diagnosis.search.trial import PROMISING, Look, looks, most_promising, refitted
from trunk_ros.effects import confused, effect


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Joint by joint."""
    for column in best.context.columns:
        if own_effects(best.hypothesis, column):
            yield Group(column, [column], partial(_swapped, best, desk, column))


def _swapped(best: Fit, desk: Desk, column: int) -> Iterator[Fit]:
    """The most promising; and of an effect that the data hardly tell from what is there, its finer forms, as
    what is there has had its own.
    """
    had, near = own_effects(best.hypothesis, column), dict[str, Fit]()
    found = most_promising(best, column, _looks(best, column), 2 * PROMISING)
    for trial in refitted(best, column, found):
        yield trial
        for term in trial.hypothesis.on(column):
            if term.effect not in had and {*effect(term.effect).refined} - {term.form}:
                near[term.effect] = min(trial, near.get(term.effect, trial), key=score)
    limit = score(best) + need(best.context, column, best.rest(column))
    for name, trial in near.items():
        if score(trial) < limit:
            yield descend_with(trial, (only(FORM, name),), desk)


def _looks(best: Fit, column: int) -> Iterator[Look]:
    local = own_effects(best.hypothesis, column)
    for gone in [*((a,) for a in local), *combinations(local, 2)]:
        bare = best.hypothesis.less(gone, column)
        like = {other for name in gone for other in confused(name)}
        yield from looks(best, bare, column, open_kinds(best.context, bare, column), PROMISING, like)


SWAP = Move("swap", groups)
