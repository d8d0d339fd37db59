"""An effect that acts on all joints alike in the place of one that most have."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import extended, kinds_of_all, open_kinds, replaced, taken
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.descent import Desk, Group, Move, descend_with, only
from trunk_ros.diagnosis.search.fit import Fit, costed, refit, refit_column
from trunk_ros.diagnosis.search.moves.drop import DROP
from trunk_ros.diagnosis.search.moves.form import FORM
from trunk_ros.diagnosis.search.moves.member import MEMBER
from trunk_ros.diagnosis.search.moves.onset import dated
from trunk_ros.diagnosis.search.moves.option import OPTION
from trunk_ros.diagnosis.search.moves.swap_many import on_most
from trunk_ros.diagnosis.search.score import SIGNIFICANT, need, priced, score
from trunk_ros.diagnosis.search.screen import PROMISED, Screen
from trunk_ros.diagnosis.search.state import exactly
from trunk_ros.diagnosis.search.trial import column_trials, refit_to_win
from trunk_ros.effects import Effect, effect
from trunk_ros.levels import REFITTED, SEVERAL


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each effect of most joints, by each that acts on all; one of several joints, as others may have more of
    the same for another effect, by those that show in the same regime. Laws with more to them than an effect
    are no exchange: they wait for their turn among what is added.
    """
    every = kinds_of_all(best.context, best.hypothesis)
    for name, term in best.hypothesis.items():
        several, kinds = len(term.columns) >= SEVERAL, [k for k in every if name not in k.replaces]
        some = [k for k in kinds if on_most(best, name) or (several and k.regime == effect(name).regime)]
        if some:
            yield Group(name, best.context.columns, partial(_swapped, best, desk, name, some))


def _swapped(best: Fit, desk: Desk, name: str, kinds: list[type[Effect]]) -> Iterator[Fit]:
    bare, leader = best.hypothesis.without(name), best
    like = [kind for kind in kinds if alike(kind, effect(name))]
    others = [kind for kind in kinds if kind not in like]
    for kind in like:
        yield from _inherited(best, desk, name, kind)
    if not others:
        return
    screen = Screen(best.context, bare)
    lost = {c: screen.left(c) - best.cost[c] for c in best.context.columns}
    for kind in others:
        again = kind.regime == effect(name).regime
        for candidate in screen.all_everywhere(kind):
            there = extended(best.context, bare, candidate)
            least = PROMISED * min(sum(lost.values()), SIGNIFICANT)
            if best.context.work.over:
                return
            if candidate.gain <= least or not (again or _may_promise(there, candidate.gain, screen, lost)):
                continue
            if candidate.lasts:  # what comes and goes imitates much: it has to win before it is dated
                trial = refit_to_win(best, there)
                promises = priced(trial) < score(best)
            else:
                trial = refit(best.context, there, np.inf if again else _half_of(screen, lost))
                if again and not effect(name).everywhere:  # a joint with more of it bends what all share
                    trial = _with_some_back(best, trial, name)
                promises = _promises(trial, screen, lost, name, again)
            if promises:
                trial = dated(trial, kind.id)
                if not _is_shown(trial, kind.id):
                    continue
                trial = _polished(best, desk, trial, name, score(leader), again)
                leader = min(leader, trial, key=score)
                yield trial


def _is_shown(trial: Fit, name: str) -> bool:
    """Whether the motion of one joint at least shows an effect: else no step that follows makes it so."""
    term = trial.hypothesis[name]
    return bool(set(term.columns) & set(trial.context.columns) - set(hidden(trial.context, term)))


def _half_of(screen: Screen, lost: dict[int, float]) -> float:
    """Squared residuals with half of what another effect explained."""
    return sum(map(screen.left, lost)) - PROMISED * sum(lost.values())


def _may_promise(there: Hypothesis, gain: float, screen: Screen, lost: dict[int, float]) -> bool:
    """Whether an effect may explain half of what the other one did, by a linear look."""
    return screen.may_come_to(there, gain) < _half_of(screen, lost)


def alike(kind: type[Effect], other: type[Effect]) -> bool:
    """Whether one effect includes the other, or both include a third."""
    return bool({kind.id, *kind.replaces} & {other.id, *other.replaces})


def _inherited(best: Fit, desk: Desk, name: str, kind: type[Effect]) -> Iterator[Fit]:
    """One effect in the place of another, by what it includes; kept while nothing changes."""
    kept = desk.trials_in(exactly(best))
    if (name, kind.id) in kept:
        yield from kept[name, kind.id]
        return
    trials = []
    for trial in _heirs(best, name, kind):
        yield trial
        trials.append(trial)
    kept[name, kind.id] = trials


def _heirs(best: Fit, name: str, kind: type[Effect]) -> Iterator[Fit]:
    """Each given up where it will not beat those before it, even with what few joints need beside it."""
    old, bare, leader = best.hypothesis[name], best.hypothesis.without(name), best
    ways = [old, replace(old, given=frozenset())] if old.given else [old]
    few = (len(best.cost) - 1) // 2
    for there in [there for way in ways for there in inherited(best.context, bare, way, kind)]:
        trial = refit_to_win(leader, there, few)
        yield trial
        mended = with_what_it_stood_for(best, trial)
        leader = min(leader, trial, mended, key=score)
        yield mended


def inherited(context: Context, bare: Hypothesis, old: Term, kind: type[Effect]) -> list[Hypothesis]:
    """An effect with the values and moments that one of its like has, and the best starts of what it has
    besides; none where the motion of one of its joints cannot show that.
    """
    if not all(kind.forms_shown(context.motion(c)) for c in context.judged(old)):
        return []
    begun, shaken = [], old.form in effect(old.effect).shaking
    for form in (f for f in kind.forms if shaken or f not in kind.shaking):  # those take a move of their own
        starts = {c: kind({}, {}, form).starts(context.shown(c), 0) for c in old.columns}
        used = kind.used(form)
        shared = {p.name: old.shared[p.name] for p in used if p.shared and p.name in old.shared}
        names = [p.name for p in used if not p.shared]
        for k in range(max(map(len, starts.values()), default=0)):
            values = {c: {**starts[c][k % len(starts[c])], **old.own[c]} for c in old.columns}
            own = {c: {n: found[n] for n in names if n in found} for c, found in values.items()}
            term = Term(kind.id, form, dict(shared), own, given=old.given)
            begun.append(costed(context, Hypothesis({**bare.copy(), kind.id: term})))
    return [fit.hypothesis for fit in sorted(begun, key=lambda fit: fit.total)[:REFITTED]]


def with_what_it_stood_for(was: Fit, trial: Fit) -> Fit:
    """With a further effect on the few joints that are worse off: a law with more to it is bent to what is
    missing beside it.
    """
    context = trial.context
    worse = [c for c, cost in trial.cost.items() if cost - was.cost[c] > need(context, c, was.rest(c))]
    if 2 * len(worse) >= len(trial.cost):
        return trial
    may_go = {c: trial.cost[c] - context.least_noise(c) for c in worse}
    for column in worse:
        if score(trial) - sum(may_go.values()) >= score(was):
            break  # whatever explains it
        goal = score(was) + sum(may_go.values()) - may_go.pop(column)
        kinds = open_kinds(context, trial.hypothesis, column)
        found = column_trials(trial, column, kinds, goal=goal)
        trial = min(found, key=score, default=trial)
    return trial


def _promises(trial: Fit, screen: Screen, lost: dict[int, float], name: str, again: bool) -> bool:
    """Whether an effect explains by itself half of what the one of that ``name`` did; on two joints at least,
    if that may come back on the others.
    """
    gained = {c: screen.left(c) - trial.cost[c] for c in lost}
    if not again:
        return sum(gained.values()) > PROMISED * sum(lost.values())
    back = _on(trial, name)
    alone = [c for c in lost if c not in back]
    return sum(gained[c] > max(PROMISED * lost[c], SIGNIFICANT) for c in alone) >= SEVERAL


def _polished(best: Fit, desk: Desk, trial: Fit, name: str, goal: float, again: bool) -> Fit:
    """With what usually follows: options and members of the new one, the old one back where it is needed, and
    without what is no longer shown beside it, or with what that had stood for.
    """
    trial = descend_with(trial, (OPTION, MEMBER), desk, goal)
    if again:
        trial = descend_with(_with_some_back(best, trial, name), (only(FORM, name),), desk)
    return with_what_it_stood_for(trial, descend_with(trial, (DROP,), desk)) if trial.total < goal else trial


def _on(fit: Fit, name: str) -> list[int]:
    """The joints that have an effect."""
    return fit.hypothesis[name].columns if name in fit.hypothesis else []


def _with_some_back(was: Fit, trial: Fit, name: str) -> Fit:
    """The effect that was replaced again on joints that have more of it than all, the neediest first: on
    most, since what acts on all shows on several joints alone.
    """
    kind, context = effect(name), trial.context
    if replaced(kind, trial.hypothesis):
        return trial
    left = [c for c in was.hypothesis[name].columns if not taken(kind, trial.hypothesis, c)]
    back = _on(trial, name)
    left = [c for c in left if c in context.columns and c not in back]
    alone = len(context.columns) - len(left) - len(back)
    while left and len(left) + alone > SEVERAL:
        needy = max(left, key=lambda c: trial.cost[c] - was.cost[c])
        if trial.cost[needy] - was.cost[needy] < need(context, needy, was.rest(needy)):
            break
        left.remove(needy)
        trial = _back(was.hypothesis[name], trial, needy)
    return trial


def _back(old: Term, now: Fit, column: int) -> Fit:
    """With an effect on a joint again, as it was there or, if it has a name, begun anew."""
    kind, screen = effect(old.effect), Screen(now.context, now.hypothesis, [column])
    trials = [
        extended(now.context, now.hypothesis, candidate)
        for candidate in (screen.forms(kind, column) if kind.named else ())
    ]
    if old.effect not in now.hypothesis or now.hypothesis[old.effect].form == old.form:
        as_it_was = now.hypothesis.copy()
        as_it_was.have(column, old)
        trials.append(as_it_was)
    found = min((refit_column(now, trial, column) for trial in trials), key=score, default=now)
    return refit(now.context, found.hypothesis) if trials else now


def _with_less(best: Fit, desk: Desk) -> Iterator[Group]:
    """Each effect by what it includes, where its further values may say nothing."""
    for name in best.hypothesis:
        kinds = [k for k in kinds_of_all(best.context, best.hypothesis) if k.id in effect(name).replaces]
        if kinds:
            yield Group(name, best.context.columns, partial(_swapped, best, desk, name, kinds))


def with_more(best: Fit, desk: Desk) -> Iterator[Fit]:
    """Each effect by what includes it: a law with more to it explains as a further effect would; and with
    options of its own, which the other one is looked for with.
    """
    for name in best.hypothesis:
        kinds = [k for k in kinds_of_all(best.context, best.hypothesis) if name in k.replaces]
        for kind in kinds:
            yield from _inherited(best, desk, name, kind)
        for option in effect(name).options(best.hypothesis[name].form) if kinds else ():
            if option.keys() - best.hypothesis[name].shared.keys():
                there = best.hypothesis.copy()
                there[name].shared = option | there[name].shared
                yield refit_to_win(best, there)


SWAP_ALL = Move("swap_all", groups, descends=True)
PLAINER = Move("plainer", _with_less)
