"""A smooth curve without a name in the place of named effects, or of what nothing explains."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.discrepancy.curves import curve_fit
from trunk_ros.diagnosis.search.candidates import own_effects
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.effects import effect

FEW = 2  # effects of a joint's own from which on a curve may do instead


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Joint by joint; then all of them, in the place of what acts on all."""
    for column in best.context.columns:
        local = own_effects(best.hypothesis, column)
        left = _leaves(best, column)
        if all(effect(name).named for name in local) and (left or len(local) >= FEW):
            yield Group(column, [column], partial(_curved, best, column, local))
    shared = [n for n in best.hypothesis if effect(n).everywhere and n not in best.context.known]
    if shared and not best.hypothesis.curved and all(_leaves(best, c) for c in best.context.columns):
        yield Group("all", best.context.columns, partial(_everywhere, best, shared))


def _leaves(best: Fit, column: int) -> bool:
    return best.cost[column] / best.context.count(column) - 1.0 > best.context.rest(column)


def _curved(best: Fit, column: int, local: list[str]) -> Iterator[Fit]:
    """With a curve in the place of all of a joint's effects, or of all but one."""
    for kept in [(), *((name,) for name in local)]:
        bare = best.hypothesis.less([name for name in local if name not in kept], column)
        trial = curve_fit(best.context, bare, column)
        if trial is not None:
            yield Fit(trial.hypothesis, best.cost | trial.cost, best.context)


def _everywhere(best: Fit, shared: list[str]) -> Iterator[Fit]:
    bare, cost = best.hypothesis, dict(best.cost)
    for name in shared:
        bare = bare.without(name)
    for column in best.context.columns:
        trial = curve_fit(best.context, bare, column)
        if trial is None:
            return
        bare, cost = trial.hypothesis, cost | trial.cost
    yield Fit(bare, cost, best.context)


CURVE = Move("curve", groups, grows=True)
