"""A smooth curve without a name in the place of named effects, or of what nothing explains."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.discrepancy.curves import curve_fit
from trunk_ros.diagnosis.search.candidates import own_effects
from trunk_ros.diagnosis.search.descent import Desk, Group, Move, state_of
from trunk_ros.diagnosis.search.fit import Fit, fit
from trunk_ros.diagnosis.search.score import beats, score
from trunk_ros.effects import effect

CLEARER = 0.02  # of what the names explain: what a curve must explain beyond them
FEW = 2  # effects of a joint's own from which on a curve may do instead


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """All joints together, since what has no name is mostly on each."""
    yield Group("any", best.context.columns, partial(_curves, best, desk))


def _curves(best: Fit, desk: Desk) -> Iterator[Fit]:
    """Beside what acts on all joints, or in its place."""
    yield from _on_joints(best, desk)
    shared = [n for n in best.hypothesis if effect(n).everywhere and n not in best.context.known]
    if shared and not best.hypothesis.curved and all(_leaves(best, c) for c in best.context.columns):
        yield from _everywhere(best, shared)


def _on_joints(best: Fit, desk: Desk) -> Iterator[Fit]:
    """With curves on all joints that are better off with one."""
    now = best
    for column in best.context.columns:
        local = own_effects(now.hypothesis, column)
        named = all(effect(name).named for name in local)
        key = ("curve", column, *state_of(now, [column]))
        if named and (_leaves(now, column) or len(local) >= FEW) and key not in desk.kept:
            trial = min(_curved(now, column, local), key=score, default=now)
            if beats(trial, now) and _is_clear(now, trial, column, local):
                now = trial
            else:
                desk.kept[key] = None
    if now is not best:
        yield now


def _is_clear(now: Fit, trial: Fit, column: int, local: list[str]) -> bool:
    """Whether a curve explains clearly more than one or two names do, if it is to take their place."""
    if not local or len(local) > FEW:
        return True
    without = fit(now.context, now.hypothesis.less(local, column), [column]).cost[column]
    return now.cost[column] - trial.cost[column] > CLEARER * (without - now.cost[column])


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
