"""One effect in the place of one or two of a joint's."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import combinations

from trunk_ros.diagnosis.search.candidates import open_kinds, own_effects
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.score import score
from trunk_ros.diagnosis.search.trial import column_trials

REFITTED = 5  # candidates that are refitted in full


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Joint by joint."""
    for column in best.context.columns:
        if own_effects(best.hypothesis, column):
            yield Group(column, [column], partial(_swapped, best, column))


def _swapped(best: Fit, column: int) -> Iterator[Fit]:
    local, now = own_effects(best.hypothesis, column), best.hypothesis
    for gone in [*((a,) for a in local), *combinations(local, 2)]:
        bare = now.less(gone, column)
        for trial in column_trials(best, bare, column, open_kinds(best.context, bare, column), REFITTED):
            best = min(best, trial, key=score)
            yield trial


SWAP = Move("swap", groups)
