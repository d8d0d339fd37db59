"""A smooth curve without a name in the place of named effects, or of what nothing explains.

It comes last, where names end; or before names are exchanged, where these will not come near it.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from trunk_ros.diagnosis.discrepancy.curves import curve_fit, drawn_on, promised
from trunk_ros.diagnosis.search.candidates import OWN, own_effects
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.descent import LARGE, Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, fit
from trunk_ros.diagnosis.search.moves.add import law_of_all, trials
from trunk_ros.diagnosis.search.score import beats, priced, prices, score, with_curves_at_least
from trunk_ros.diagnosis.search.screen import PROMISED
from trunk_ros.diagnosis.search.state import state_of
from trunk_ros.effects import effect
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.curve import ON
from trunk_ros.levels import LITTLE, SEVERAL


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """All joints together, since what has no name is mostly on each."""
    yield Group("any", best.context.columns, partial(_curves, best, desk))


def early_groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Joints whose names are far from what a curve promises, once none is missing that explains much."""
    for column in best.context.columns if desk.share < LARGE else ():
        if best.beyond_noise(column) > 0.0 and _hopeless(best, desk, column):
            yield Group(column, [column], partial(_on_joints, best, desk, [column]))


def _hopeless(best: Fit, desk: Desk, column: int) -> bool:
    """Whether the names that a joint may still have would have to explain more, each, than those that it has
    do, or than the best one by itself, which may be a law of all joints, to leave as little as a curve
    promises in their place. Where one is there, it may give way to one with more to it, which is no further
    name.
    """
    local = own_effects(best.hypothesis, column)
    if not local or column in best.hypothesis.curved:
        return False
    nominal = best.context.whitened(best.context.known, column)
    each = (float(nominal @ nominal) - best.cost[column]) / len(local)
    if not any(effect(name).everywhere for name in local):
        further = (trial.cost for (_, alone), trial in trials(best, desk, [column])[0].items() if alone)
        own = best.cost[column] - min(further, default=best.cost[column])
        each = min(each, max(own, law_of_all(best, desk)))
    reached = best.rest(column) - (OWN - len(local)) * each
    bare = best.hypothesis.less(local, column)
    return reached > 0.0 and any(
        promised(best.context, bare, column, linear) < reached for linear in (True, False)
    )


def _curves(best: Fit, desk: Desk) -> Iterator[Fit]:
    """Beside what acts on all joints, or in its place."""
    yield from _on_joints(best, desk, best.context.columns)
    shared = [n for n in best.hypothesis if effect(n).everywhere and n not in best.context.known]
    if (
        shared
        and not best.hypothesis.curved
        and all(best.beyond_noise(c) > 0.0 for c in best.context.columns)
    ):
        yield from _everywhere(best, shared)


def _on_joints(best: Fit, desk: Desk, columns: list[int]) -> Iterator[Fit]:
    """With curves on all joints that are better off with one."""
    now = best
    for column in columns:
        if best.context.work.over:
            break
        local = own_effects(now.hypothesis, column)
        named = all(effect(name).named for name in local)
        key = ("curve", column, *state_of(now, [column]))
        open_ = now.beyond_noise(column) > 0.0 or _may_replace(now, column, local)
        least = with_curves_at_least(now, now.hypothesis.less(local, column), [column])
        if named and open_ and least < score(now) and key not in desk.kept:
            trial = min(_curved(now, column, local), key=score, default=now)
            if priced(trial) < score(now):
                trial = _with_those_beside(now, trial)
            if beats(trial, now) and _is_clear(now, trial, column, local):
                now = trial
            else:
                desk.kept.add(key)
    if now is not best:
        yield now


def _with_those_beside(now: Fit, trial: Fit) -> Fit:
    """With curves as well on the joints that showed what they have only beside the names that a curve took
    the place of, where these explain clearly more.
    """
    for column in sorted({c for term in trial.hypothesis.values() for c in hidden(trial.context, term)}):
        local = own_effects(trial.hypothesis, column)
        if all(effect(name).named for name in local):
            drawn = min(_curved(trial, column, local), key=score, default=trial)
            trial = drawn if _is_clear(now, drawn, column, own_effects(now.hypothesis, column)) else trial
    return trial


def _may_replace(now: Fit, column: int, local: list[str]) -> bool:
    """Whether a curve may explain what says several things, or is a curve itself, by a linear look."""
    if _claims(now, column, local) < SEVERAL and not _followed(now, column, local):
        return False
    bare = now.hypothesis.less(local, column)
    saved = prices(now.context, now.hypothesis) - prices(now.context, bare)
    left = promised(now.context, bare, column)
    return np.isinf(left) or PROMISED * left < now.rest(column) + saved


def _is_clear(now: Fit, trial: Fit, column: int, local: list[str]) -> bool:
    """Whether a curve explains clearly more than what says one or two things, if it is to take its place:
    their forms may be a little off. A name that is a curve has no form, but over the same joint it is one.
    """
    if not local or _claims(now, column, local) > SEVERAL:
        return True
    kept = {term.effect for term in trial.hypothesis.on(column)}
    along = _followed(now, column, [name for name in local if name not in kept])
    drawn = drawn_on(now.context, trial.hypothesis, column)
    if along and drawn and all(term.words[column][ON] not in along for term in drawn):
        return True
    without = fit(now.context, now.hypothesis.less(local, column), [column]).cost[column]
    return now.cost[column] - trial.cost[column] > LITTLE * (without - now.cost[column])


def _followed(now: Fit, column: int, local: list[str]) -> set[str]:
    """Over which other joints the names of a joint draw curves."""
    curves = [name for name in local if issubclass(effect(name), Bank)]
    return {word for name in curves for word in now.hypothesis.get_words(name, column)}


def _claims(now: Fit, column: int, local: list[str]) -> int:
    """How many things are said of a joint: names, and the moments at which they begin, change and end."""
    return sum(1 + len(now.hypothesis[name].moments(column)) for name in local)


def _curved(best: Fit, column: int, local: list[str]) -> Iterator[Fit]:
    """With a curve in the place of all of a joint's effects, and in that of all but one where this promises
    most.
    """
    bares = [
        fit(best.context, best.hypothesis.less([name for name in local if name != kept], column), [column])
        for kept in ["", *local]
    ]
    first, *others = (bare.hypothesis for bare in bares)
    others.sort(key=lambda bare: promised(best.context, bare, column))
    for bare in [first, *others[:1]]:
        trial = curve_fit(best.context, bare, column)
        if trial is not None:
            yield Fit(trial.hypothesis, best.cost | trial.cost, best.context)


def _everywhere(best: Fit, shared: list[str]) -> Iterator[Fit]:
    bare, cost = best.hypothesis, dict(best.cost)
    for name in shared:
        bare = bare.without(name)
    if with_curves_at_least(best, bare, best.context.columns) >= score(best):
        return
    for column in best.context.columns:
        trial = curve_fit(best.context, bare, column)
        if trial is None:
            return
        bare, cost = trial.hypothesis, cost | trial.cost
    yield Fit(bare, cost, best.context)


CURVE = Move("curve", groups, grows=True, resort=True)
EARLY_CURVE = Move("early_curve", early_groups, grows=True)
