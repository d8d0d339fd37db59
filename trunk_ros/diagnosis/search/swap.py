"""Other effects, or a curve without a name, in the place of those that an explanation has."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

from trunk_ros.diagnosis.discrepancy.curves import curve_fit, drawn_on
from trunk_ros.diagnosis.hypothesis import Explanation, Term
from trunk_ros.diagnosis.search.candidates import extended, replaced, taken, usable
from trunk_ros.diagnosis.search.fit import Fit, fit
from trunk_ros.diagnosis.search.form import forms, options
from trunk_ros.diagnosis.search.revise import better, drop, members
from trunk_ros.diagnosis.search.score import need
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects import Effect, effect

if TYPE_CHECKING:
    from trunk_ros.diagnosis.search.greedy import Search

CLEARER = 0.02  # of the misfit: what a curve must explain beyond the named effects to take their place
HALF = 0.5  # of a misfit: a curve that leaves more of it is over something else than what is at work
OVER_TIME = 0.15  # likewise over time, by which a curve imitates whatever moves slowly
ALONE = 2  # joints that what acts on all must explain by itself
MOST = 0.5  # of the joints: an effect on as many may be one of all
REFITTED = 5  # candidates of an exchange that are refitted in full


def exchange(search: Search, now: Fit) -> Fit:
    """Replace one or two effects of a joint by one that explains the joint better, or begin one anew."""
    for column in search.problem.columns:
        key = (column, search.problem.version, now.explanation.key(column))
        if key in search.settled:
            continue
        local = local_effects(now, column)
        for gone in [*((a,) for a in local), *combinations(local, 2)]:
            if all(name in now.explanation and column in now.explanation[name].own for name in gone):
                now = _exchanged(search, now, column, gone)
        search.settled.add((column, search.problem.version, now.explanation.key(column)))
    return now


def _exchanged(search: Search, now: Fit, column: int, gone: tuple[str, ...]) -> Fit:
    bare = now.explanation.less(gone, column)
    screen = Screen(search.problem, bare, [column])
    kinds = [k for k in search.local_kinds() if search.open(k.id, column, bare)]
    for candidate in screen.ranked(kinds, column, REFITTED):
        trial = search.refit_column(now, extended(search.problem, bare, candidate), column, now)
        if search.credible(trial.explanation, column):
            now = better(search, now, trial)
    return now


def exchange_everywhere(search: Search, now: Fit) -> Fit:
    """Replace an effect that is on most joints by another that acts on all alike."""
    for name in list(now.explanation):
        if name not in now.explanation or not _on_most(search, now.explanation, name):
            continue
        was, bare = now, now.explanation.without(name)
        screen = Screen(search.problem, bare)
        for kind in usable(search.problem):
            if kind.everywhere and kind.id not in now.explanation:
                for candidate in screen.all_everywhere(kind):
                    trial = search.refit(extended(search.problem, bare, candidate))
                    trial = members(search, options(search, trial))
                    if kind.regime == effect(name).regime:
                        trial = forms(search, _with_some_back(search, was, trial, name))
                    if trial.total < search.score(now):  # or leaving out cannot make it better
                        now = better(search, now, drop(search, trial))
    return now


def exchange_on_many(search: Search, now: Fit) -> Fit:
    """Replace an effect that most joints have by one that it is confused with, on all of them at once: what
    the arm shares moves along.
    """
    for name in list(now.explanation):
        if not any(effect(other).everywhere for other in now.explanation):
            break
        for rival, _ in effect(name).confused_with:
            if name not in now.explanation or not _on_most(search, now.explanation, name):
                break
            kind = effect(rival)
            if kind in search.local_kinds():
                for trial in _on_the_same(search, now, name, kind):
                    now = better(search, now, trial)
    return now


def _on_the_same(search: Search, now: Fit, name: str, kind: type[Effect]) -> Iterator[Fit]:
    """An effect in the place of another on all of its joints, and of all that these have of its regime."""
    columns, less = now.explanation[name].columns, now.explanation.without(name)
    alone = less
    for other in [t.effect for t in less.values() if effect(t.effect).regime == kind.regime]:
        alone = alone.without(other)
    for bare in (less, alone) if len(alone) < len(less) else (less,):
        out = _with(search, bare, kind, [c for c in columns if c in search.problem.columns])
        if out is not None:
            trial = search.refit(out)
            if all(search.credible(trial.explanation, c) for c in columns):
                yield drop(search, trial)


def _with(search: Search, bare: Explanation, kind: type[Effect], columns: list[int]) -> Explanation | None:
    """An effect on further joints, in one form; None where one of them does not show it."""
    screen, out = Screen(search.problem, bare, columns), bare
    form = bare[kind.id].form if kind.id in bare else kind.forms[0]
    for column in columns:
        if kind.id not in bare or column not in bare[kind.id].own:
            start = screen.local_form(kind, form, column)
            if start is None:
                return None
            out = extended(search.problem, out, start)
    return out


def _with_some_back(search: Search, was: Fit, trial: Fit, name: str) -> Fit:
    """The effect that was replaced again on joints that have more of it than all, the neediest first: on
    most, since what acts on all shows on several joints alone.
    """
    kind = effect(name)
    if replaced(kind, trial.explanation):
        return trial
    left = [c for c in was.explanation[name].columns if not taken(kind, trial.explanation, c)]
    left = [c for c in left if c in search.problem.columns]
    alone = len(search.problem.columns) - len(left)
    while left and len(left) + alone > ALONE:
        needy = max(left, key=lambda c: trial.cost[c] - was.cost[c])
        if trial.cost[needy] - was.cost[needy] < need(search.problem, needy):
            break
        left.remove(needy)
        trial = _back(search, was.explanation[name], trial, needy)
    return trial


def _back(search: Search, old: Term, now: Fit, column: int) -> Fit:
    """With an effect on a joint again, as it was there or, if it has a name, begun anew."""
    kind, screen = effect(old.effect), Screen(search.problem, now.explanation, [column])
    trials = [
        extended(search.problem, now.explanation, candidate)
        for candidate in (screen.forms(kind, column) if kind.named else ())
    ]
    if old.effect not in now.explanation or now.explanation[old.effect].form == old.form:
        as_it_was = now.explanation.copy()
        term = as_it_was.setdefault(old.effect, Term(old.effect, old.form, dict(old.shared), given=old.given))
        term.own[column] = dict(old.own[column])
        if column in old.words:
            term.words[column] = dict(old.words[column])
        trials.append(as_it_was)
    return min(map(search.refit, trials), key=search.score, default=now)


def _on_most(search: Search, explanation: Explanation, name: str) -> bool:
    columns = search.problem.columns
    there = set(explanation[name].columns) & set(columns)
    return effect(name).everywhere or len(there) > MOST * len(columns)


def unname(search: Search, now: Fit) -> Fit | None:
    """Put a smooth curve in the place of named effects, or of a rest, where that explains a joint better;
    None if nowhere.
    """
    changed = False
    everywhere = _unnamed_everywhere(search, now)
    for column in search.problem.columns:
        key = ("unname", column, search.problem.version, now.explanation.key(column))
        if key not in search.settled:
            search.settled.add(key)
            trial = _unnamed(search, now, column)
            changed |= trial is not now
            now = trial
    if everywhere is not None and search.score(everywhere) < search.score(now):
        return everywhere
    return now if changed else None


def _unnamed_everywhere(search: Search, now: Fit) -> Fit | None:
    """Curves on all joints in the place of what acts on all of them, where much is left beside that."""
    problem, bare = search.problem, now.explanation
    for name in [n for n in bare if effect(n).everywhere and n not in problem.known]:
        bare = bare.without(name)
    rest = {c: now.cost[c] / problem.count(c) - 1.0 for c in problem.columns}
    key = ("unname everywhere", problem.version, *(now.explanation.key(c) for c in problem.columns))
    if len(bare) == len(now.explanation) or key in search.settled or bare.curved:
        return None
    search.settled.add(key)
    if any(rest[c] < problem.rest(c) for c in problem.columns):
        return None
    cost: dict[int, float] = {}
    for column in problem.columns:
        trial = curve_fit(problem, bare, column)
        nominal = fit(problem, bare, [column]).cost[column]
        if trial is None or not _tells(problem, trial, column, nominal):
            return None
        bare, cost = trial.explanation, cost | trial.cost
    return Fit(bare, cost)


def _unnamed(search: Search, now: Fit, column: int) -> Fit:
    local = local_effects(now, column)
    rest = now.cost[column] / search.problem.count(column) - 1.0
    if not all(effect(name).named for name in local) or (
        len(local) < 2 and rest < search.problem.rest(column)
    ):
        return now
    nominal = fit(search.problem, now.explanation.less(local, column), [column]).cost[column]
    best = now
    for kept in [(), *((name,) for name in local)]:
        bare = now.explanation.less([name for name in local if name not in kept], column)
        trial = curve_fit(search.problem, bare, column)
        if trial is not None:
            best = better(search, best, Fit(trial.explanation, now.cost | trial.cost))
    gained = now.cost[column] - best.cost[column]
    clearly = len(local) >= 3 or gained > CLEARER * (nominal - now.cost[column])
    return best if clearly and _tells(search.problem, best, column, nominal) else now


def believed(search: Search, now: Fit) -> Fit:
    """Without the curves that explain too little beside what has come or gone since they were drawn."""
    for column in now.explanation.curved & set(search.problem.columns):
        drawn = [term.effect for term in drawn_on(search.problem, now.explanation, column)]
        less = search.refit_column(now, now.explanation.less(drawn, column), column)
        now = now if _tells(search.problem, now, column, less.cost[column]) else less
    return now


def _tells(problem: Problem, curved: Fit, column: int, nominal: float) -> bool:
    """Whether a curve leaves so little of what there was without it that it is over what is at work."""
    noise = problem.count(column)
    most = OVER_TIME if curved.explanation.over_time(column) else HALF
    return curved.cost[column] - noise < most * (nominal - noise)


def local_effects(now: Fit, column: int) -> list[str]:
    """Effects that a joint has of its own, or by values of its own."""
    return [t.effect for t in now.explanation.on(column) if not effect(t.effect).everywhere or _by_itself(t)]


def _by_itself(term: Term) -> bool:
    """Whether each joint has a size of its own, which no description states."""
    return not term.given and not effect(term.effect).own_parameters(term.form)[0].shared
