"""Changes to an explanation that are tried after each step: other forms, other joints, fewer effects."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.hypothesis import Explanation, bind_column
from trunk_ros.diagnosis.search.candidates import extended, taken
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.effects import effect

if TYPE_CHECKING:
    from trunk_ros.diagnosis.search.greedy import Search

ONSET = "onset"
REACH = 1.0  # s
NEARBY = np.linspace(-REACH, REACH, 201)  # s
CLEARLY = 2.0  # squared unit-noise residuals
STRONG = 1.0  # of the noise power: a rest from which on an explanation is known to be incomplete
SHARED_SLICE = 0.5  # of such a rest of all joints
NOTHING = 0.05  # of what an effect is on the joint that has most of it
SURE = 9.0  # squared unit-noise residuals: three standard deviations
SLICE = 0.15  # of such a rest, for each value


def better(search: Search, now: Fit, trial: Fit | None) -> Fit:
    """The one with the lower score."""
    return trial if trial is not None and search.score(trial) < search.score(now) - CLEARLY else now


def moments(search: Search, now: Fit) -> Fit:
    """Move what happens at one moment to where it fits best nearby: a fit sees only what lies next to it."""
    for term in list(now.explanation.values()):
        for column in [c for c in term.columns if ONSET in term.own[c] and c in search.problem.columns]:
            now = moved(search, now, term.effect, column, term.own[column][ONSET] + NEARBY)
    return now


def moved(search: Search, now: Fit, name: str, column: int, moments: Array) -> Fit:
    """With what happens at one moment at the best of ``moments`` (k,) s, if that is better."""
    trial, costs = now.explanation.copy(), []
    own = trial[name].own[column]
    for moment in np.maximum(moments, 0.0):
        own[ONSET] = float(moment)
        costs.append(float(np.sum(search.problem.whitened(trial, column) ** 2)))
    own[ONSET] = max(float(moments[int(np.argmin(costs))]), 0.0)
    return better(search, now, search.refit_column(now, trial, column))


def members(search: Search, now: Fit) -> Fit:
    """Which joints an effect is on that acts on all; one without values of a joint's own is left by none."""
    for name in [n for n in now.explanation if effect(n).everywhere]:
        if name not in now.explanation:  # one that includes it has come in its place
            continue
        alike = all(p.shared for p in effect(name).own_parameters(now.explanation[name].form))
        for column in search.problem.columns:
            there = column in now.explanation[name].columns
            change = _joined if not there else None if alike else _left
            if change is not None:
                now = better(search, now, change(search, now, name, column))
    return now


def _left(search: Search, now: Fit, name: str, column: int) -> Fit | None:
    if len(now.explanation[name].columns) == 1:
        return None
    return search.refit_column(now, now.explanation.without(name, column), column)


def _joined(search: Search, now: Fit, name: str, column: int) -> Fit | None:
    kind, form, joined = effect(name), now.explanation[name].form, now.explanation.copy()
    if all(p.shared for p in kind.own_parameters(form)):
        joined[name].own[column] = {}
    elif taken(kind, joined, column):
        return None
    else:
        start = Screen(search.problem, now.explanation, [column]).local_form(kind, form, column)
        if start is None:
            return None
        joined = extended(search.problem, now.explanation, replace(start, column=None, columns=(column,)))
    return search.refit_column(now, joined, column)


def sources(search: Search, now: Fit) -> Fit:
    """Leave out one of a joint's several sources, or find another effect in its place."""
    for name in [n for n in now.explanation if effect(n).texts and effect(n).named]:
        for column in now.explanation[name].columns if name in now.explanation else ():
            while (count := len(now.explanation.get_words(name, column))) > 1:
                trials = [_less_a_source(search, now, name, column, gone) for gone in range(count)]
                best = min(trials, key=search.score)
                if search.score(best) > search.score(now):
                    break
                now = best
    return now


def _less_a_source(search: Search, now: Fit, name: str, column: int, gone: int) -> Fit:
    """Without one source, alone or with what then explains most."""
    bare, kind = now.explanation.copy(), effect(name)
    term = bare[name]
    words, own = list(term.words[column].values()), term.own[column]
    gains = [own.pop(kind.parameters[k].name) for k in range(len(words))]
    left = [k for k in range(len(words)) if k != gone]
    term.words[column] = {kind.texts[new]: words[old] for new, old in enumerate(left)}
    own |= {kind.parameters[new].name: gains[old] for new, old in enumerate(left)}
    best = search.refit_column(now, bare, column)
    screen = Screen(search.problem, best.explanation, [column])
    kinds = [k for k in search.local_kinds() if k.id != name and search.open(k.id, column, bare)]
    for candidate in screen.ranked(kinds, column, 2):
        trial = search.refit_column(now, extended(search.problem, best.explanation, candidate), column, best)
        if search.credible(trial.explanation, column):
            best = better(search, best, trial)
    return best


def incredible(search: Search, now: Fit) -> Fit:
    """Take out, for good, what a fit has moved to where the motion cannot show it."""
    for term in list(now.explanation.values()):
        for column in term.columns:
            seen = column in search.problem.columns
            if seen and not search.shows(now.explanation, bind_column(term, column), column):
                search.barred.add((term.effect, column))
                now = search.refit_column(now, now.explanation.without(term.effect, column), column)
    return now


def drop(search: Search, now: Fit) -> Fit:
    """Leave out, one at a time, what is not missed."""
    while True:
        trials = [_dropped(search, now, name, column) for name, column in _droppable(search, now.explanation)]
        best = min(trials, key=search.score, default=None)
        if best is None or search.score(best) > search.score(now):
            return now
        now = best


def slices(search: Search, now: Fit) -> Fit:
    """Leave out what explains little beside what nothing explains: it is a slice of that."""
    for column in search.problem.columns:
        while True:
            rest = now.cost[column] - search.problem.count(column)
            if rest < STRONG * search.problem.count(column):
                break
            own = [n for n, c in _droppable(search, now.explanation) if c == column]
            worth = {n: _worth(search, now, n, column) / (SLICE * rest) for n in own}
            least = min(own, key=worth.__getitem__, default=None)
            if least is None or worth[least] > 1.0:
                break
            now = _dropped(search, now, least, column)
    return _shared_slices(search, now)


def bystanders(search: Search, now: Fit) -> Fit:
    """Leave joints out of what acts on all alike where it comes to nothing."""
    for name in [n for n in now.explanation if effect(n).everywhere and effect(n).scalable]:
        term, lead = now.explanation[name], effect(name).parameters[0].name
        sizes = {c: abs(own.get(lead, 0.0)) for c, own in term.own.items()}
        for column in [c for c, size in sizes.items() if size < NOTHING * max(sizes.values())]:
            without = _dropped(search, now, name, column)
            now = without if without.total - now.total < SURE else now
    return now


def _shared_slices(search: Search, now: Fit) -> Fit:
    """The same for what acts on all joints, beside all that is left on them."""
    for name in [n for n in now.explanation if effect(n).everywhere]:
        columns = [c for c in now.explanation[name].columns if c in search.problem.columns]
        rest = sum(now.cost[c] - search.problem.count(c) for c in columns)
        without = _dropped(search, now, name, None)
        strong = rest > STRONG * sum(map(search.problem.count, columns))
        if strong and without.total - now.total < SHARED_SLICE * rest:
            now = without
    return now


def _worth(search: Search, now: Fit, name: str, column: int) -> float:
    """What an effect explains on a joint per value that it has there."""
    gain = _dropped(search, now, name, column).cost[column] - now.cost[column]
    return gain / max(sum(f.effect == name for f in now.explanation.free([column])), 1)


def _droppable(search: Search, explanation: Explanation) -> list[tuple[str, int | None]]:
    every = [
        (t.effect, c)
        for t in explanation.values()
        for c in ([None] if effect(t.effect).everywhere else t.columns)
    ]
    return [(n, c) for n, c in every if c is None or search.credible(explanation.without(n, c), c)]


def _dropped(search: Search, now: Fit, name: str, column: int | None) -> Fit:
    less = now.explanation.without(name, column)
    return search.refit(less) if column is None else search.refit_column(now, less, column)
