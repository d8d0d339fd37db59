"""Changes of what an effect is in detail: another form, and values that it may have besides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from trunk_ros.diagnosis.hypothesis import Explanation
from trunk_ros.diagnosis.search.candidates import extended, given, seen_forms
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.revise import better
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.effects import effect
from trunk_ros.parameter import Parameter

if TYPE_CHECKING:
    from trunk_ros.diagnosis.search.greedy import Search

OPTION_SIZES = (0.4, 1.6)  # of the usual value


def forms(search: Search, now: Fit) -> Fit:
    """The best form of each effect."""
    for name in list(now.explanation):
        kind, columns = effect(name), now.explanation[name].columns
        for form in kind.forms:
            seen = all(form in seen_forms(search.problem, kind, c) for c in columns)
            if seen and form != now.explanation[name].form:
                trial = _reformed(search, now, name, form)
                if trial and all(
                    search.credible(trial.explanation, c) for c in trial.explanation[name].columns
                ):
                    now = better(search, now, trial)
    return now


def _reformed(search: Search, now: Fit, name: str, form: str) -> Fit | None:
    """An effect in another form on the joints that it is on.

    A refined form leaves the values of a joint as they are where its motion does not show more.
    """
    kind, old = effect(name), now.explanation[name]
    if not kind.own_parameters(form):
        return None
    refined = form in kind.refined and old.form not in kind.refined
    bare = now.explanation.without(name)
    out = bare
    screen = Screen(search.problem, bare, old.columns)
    for column in old.columns:
        candidate = screen.local_form(kind, form, column)
        if candidate is None:
            return None
        out = extended(search.problem, out, replace(candidate, column=None, columns=(column,)))
    out[name].shared |= {
        p.name: old.shared[p.name] for p in kind.own_parameters(form) if p.optional and p.name in old.shared
    }
    trial = search.refit(out)
    if refined:
        trial = min([trial, *map(search.refit, _refinements(now.explanation, name, form))], key=search.score)
    for column in [c for c in old.columns if refined and not search.credible(trial.explanation, c)]:
        kept = trial.explanation.copy()
        kept[name].own[column] = dict(old.own[column])
        trial = search.refit_column(trial, kept, column)
    return trial


def _refinements(explanation: Explanation, name: str, form: str) -> Iterator[Explanation]:
    """An effect with the values that it has, and what a refined form adds at each of its start values."""
    known = effect(name).own_parameters(explanation[name].form)
    added = [p for p in effect(name).own_parameters(form) if p not in known]
    for k in range(max((len(p.scan) for p in added), default=0)):
        out = explanation.copy()
        out[name].form = form
        for parameter in added:
            start = parameter.scan[k % len(parameter.scan)] if parameter.scan else parameter.typical
            for values in [out[name].shared] if parameter.shared else out[name].own.values():
                values[parameter.name] = start
        yield out


def options(search: Search, now: Fit) -> Fit:
    """Free what an effect may have besides: a payload, or what the arm's description states."""
    for name in list(now.explanation):
        if name not in now.explanation:
            continue
        kind = effect(name)
        for parameter in kind.own_parameters(now.explanation[name].form):
            if parameter.optional and parameter.shared:
                now = better(search, now, _toggled(search, now, name, parameter))
        if now.explanation[name].given & set(given(kind, search.problem)):
            trial = now.explanation.copy()
            trial[name].given = frozenset()
            trial[name].shared.pop("payload", None)
            now = better(search, now, search.refit(trial))
        elif given(kind, search.problem):
            now = better(search, now, _as_stated(search, now, name))
    return now


def _as_stated(search: Search, now: Fit, name: str) -> Fit | None:
    """With what the arm's description states in the place of fitted values."""
    bare = now.explanation.without(name)
    found = Screen(search.problem, bare).all_everywhere(effect(name))
    stated = next((c for c in found if not c.free), None)
    if stated is None or stated.form != now.explanation[name].form:
        return None
    trial = search.refit(extended(search.problem, bare, stated))
    for parameter in effect(name).own_parameters(stated.form):
        if parameter.optional and parameter.shared:
            trial = better(search, trial, _toggled(search, trial, name, parameter))
    return trial


def _toggled(search: Search, now: Fit, name: str, parameter: Parameter) -> Fit:
    """With a shared option if it was without, and the other way round.

    A value of a joint that has made up for a missing payload does not find back: so the joints start anew as
    well.
    """
    trial = now.explanation.copy()
    if trial[name].shared.pop(parameter.name, None) is not None:
        return search.refit(trial)
    trial[name].shared[parameter.name] = parameter.typical
    return min([search.refit(trial), *_anew(search, now, name, parameter)], key=search.score)


def _anew(search: Search, now: Fit, name: str, parameter: Parameter) -> Iterator[Fit]:
    """The effect in each form, started with small and large values of a shared option."""
    bare, free = now.explanation.without(name), not now.explanation[name].given
    screen = Screen(search.problem, bare)
    for form in effect(name).forms:
        for size in OPTION_SIZES:
            found = screen.all_everywhere(effect(name), form, {parameter.name: size * parameter.typical})
            starts = [c for c in found if c.free == free] or found
            if starts:
                yield search.refit(extended(search.problem, bare, starts[0]))
