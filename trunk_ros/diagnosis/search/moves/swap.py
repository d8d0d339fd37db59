"""One effect in the place of one or two of a joint's."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import combinations

from trunk_ros.diagnosis.search.candidates import open_kinds, own_effects
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.trial import PROMISING, Look, looks, most_promising, refitted
from trunk_ros.effects import confused


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Joint by joint."""
    for column in best.context.columns:
        if own_effects(best.hypothesis, column):
            yield Group(column, [column], partial(_swapped, best, column))


def _in_place_of_curves(best: Fit, desk: Desk) -> Iterator[Group]:
    """Joints that have a curve: a search may have ended before it came to their name."""
    return (group for group in groups(best, desk) if group.what in best.hypothesis.curved)


def _swapped(best: Fit, column: int) -> Iterator[Fit]:
    yield from refitted(best, column, most_promising(best, column, _looks(best, column), 2 * PROMISING))


def _looks(best: Fit, column: int) -> Iterator[Look]:
    local = own_effects(best.hypothesis, column)
    for gone in [*((a,) for a in local), *combinations(local, 2)]:
        bare = best.hypothesis.less(gone, column)
        like = {other for name in gone for other in confused(name)}
        yield from looks(best.context, bare, column, open_kinds(best.context, bare, column), like)


SWAP = Move("swap", groups)
NAMED = Move("named", _in_place_of_curves)
