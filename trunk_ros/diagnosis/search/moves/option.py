"""What an effect may have besides: a shared option such as a payload, or what the arm itself states."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import extended, given, shown_forms
from trunk_ros.diagnosis.search.descent import Desk, Group, Move
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.score import score
from trunk_ros.diagnosis.search.screen import PROMISED, Screen
from trunk_ros.diagnosis.search.trial import may_win, refit_to_win
from trunk_ros.effects import effect
from trunk_ros.levels import HALF, REFITTED
from trunk_ros.parameter import Parameter

SIZES = (0.4, 1.6)  # of the usual value


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """The options of each effect."""
    for name, term in best.hypothesis.items():
        if options_of(name, term.form) or given(effect(name), best.context):
            trials, promise = partial(_changed, best, name), partial(_promise, best, name)
            yield Group(name, best.context.columns, trials, promise)


def options_of(name: str, form: str) -> list[Parameter]:
    """The shared parameters that an effect may do without."""
    return [p for p in effect(name).own_parameters(form) if p.optional and p.shared]


def put_down(term: Term, option: str) -> None:
    """Be without an option, and what was said of when it is there."""
    for name in [name for name in term.shared if name == option or name.startswith(f"{option}_")]:
        del term.shared[name]


def _promise(now: Fit, name: str) -> float:
    """What options that an effect is without and values that are no longer as stated may gain, and all that
    may be saved.
    """
    term, looks = now.hypothesis[name], [0.0]
    options = options_of(name, term.form)
    there = [_with(now, name, p) for p in options if p.name not in term.shared]
    there += [_with(now, name, p, start) for p in options for start in _elsewhere(term, p)]
    if there:
        screen = Screen(now.context, now.hypothesis)
        looks += map(screen.seen, there)
    if term.given:
        looks.append(Screen(now.context, _freed(now, name)).seen())
    return score(now) - now.total + max(looks) / PROMISED


def _changed(now: Fit, name: str) -> Iterator[Fit]:
    term, options = now.hypothesis[name], options_of(name, now.hypothesis[name].form)
    for parameter in options:
        yield from toggled(now, name, parameter)
    stated = given(effect(name), now.context)
    if term.given & set(stated):
        yield refit_to_win(now, _freed(now, name))
    elif stated:
        yield from _as_stated(now, name)


def _freed(now: Fit, name: str) -> Hypothesis:
    """With values of the joints' own in the place of stated ones, and without options."""
    out = now.hypothesis.copy()
    out[name].given = frozenset()
    for parameter in options_of(name, out[name].form):
        put_down(out[name], parameter.name)
    return out


def _elsewhere(term: Term, parameter: Parameter) -> list[float]:
    """Starts of an option that a term has which are far from its value."""
    if parameter.name not in term.shared or parameter.name in term.given:
        return []
    low, high = parameter.bounds
    value, far = term.shared[parameter.name], HALF * (high - low)
    return [start for start in parameter.scan if abs(start - value) > far]


def _with(now: Fit, name: str, parameter: Parameter, start: float | None = None) -> Hypothesis:
    """With an option at a value, or at its usual one."""
    out = now.hypothesis.copy()
    out[name].shared[parameter.name] = parameter.typical if start is None else start
    return out


def _as_stated(now: Fit, name: str) -> Iterator[Fit]:
    """With what the arm's description states in the place of fitted values, with and without options."""
    bare = now.hypothesis.without(name)
    found = Screen(now.context, bare).all_everywhere(effect(name))
    stated = next((c for c in found if not c.free), None)
    if stated is not None and stated.form == now.hypothesis[name].form:
        trial = refit(now.context, extended(now.context, bare, stated))
        yield trial
        for parameter in options_of(name, stated.form):
            yield from toggled(trial, name, parameter)


def toggled(now: Fit, name: str, parameter: Parameter) -> Iterator[Fit]:
    """With a shared option if it was without, and the other way round, or with a value that is far from what
    it has: a fit finds only what is near.

    A value of a joint that has made up for a missing payload does not find back: so where it is something to
    be carried, the joints start anew as well, in each form, with little and with much of it, beside the other
    options that there are.
    """
    trial = now.hypothesis.copy()
    if parameter.name in trial[name].shared:
        put_down(trial[name], parameter.name)
        yield refit_to_win(now, trial)
        for start in _elsewhere(now.hypothesis[name], parameter):
            yield refit_to_win(now, _with(now, name, parameter, start))
        return
    for start in parameter.scan or (parameter.typical,):
        yield refit_to_win(now, _with(now, name, parameter, start))
    if not parameter.carried:
        return
    bare, free, shared = now.hypothesis.without(name), not now.hypothesis[name].given, trial[name].shared
    screen = Screen(now.context, bare)
    begun = []
    kind, old = effect(name), now.hypothesis[name]
    for form in shown_forms(kind, now.context, old.columns):
        if form in kind.shaking and form != old.form:
            continue  # takes by far the most time: another move's
        others = {p.name: shared[p.name] for p in options_of(name, form) if p.name in shared}
        for size in SIZES:
            values = others | {parameter.name: size * parameter.typical}
            found = screen.all_everywhere(kind, form, values)
            begun += ([c for c in found if c.free == free] or found)[:1]
    for candidate in sorted(begun, key=lambda c: -c.gain)[:REFITTED]:
        there = extended(now.context, bare, candidate)
        if may_win(now, there, screen, candidate.gain):
            yield refit_to_win(now, there)


OPTION = Move("option", groups, settles=True)
