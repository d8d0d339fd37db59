"""Another form of an effect: Gaussian or exponential, one mode or two, straight or bent."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.candidates import shown_forms
from trunk_ros.diagnosis.search.credible import hidden
from trunk_ros.diagnosis.search.descent import COARSE, Desk, Group, Move, descend_with
from trunk_ros.diagnosis.search.fit import Fit, costed, refit, refit_column
from trunk_ros.diagnosis.search.moves.drop import DROP
from trunk_ros.diagnosis.search.score import priced, prices, score
from trunk_ros.diagnosis.search.screen import PROMISED, Screen
from trunk_ros.diagnosis.search.trial import begun_on
from trunk_ros.effects import Effect, effect


def groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """The forms of each effect, but for those by which joints move each other."""
    return _groups(best, desk, shaking=False)


def shaking_groups(best: Fit, desk: Desk) -> Iterator[Group]:
    """Those by which joints move each other: as they take by far the most time, what else mends comes
    before. While large things are missing, only forms that mend much before they are fitted.
    """
    return _groups(best, desk, shaking=True, early=desk.share >= COARSE[0])


def _mending(best: Fit, desk: Desk, name: str, forms: Sequence[str]) -> Iterator[Fit]:
    shown = shown_forms(effect(name), best.context, best.hypothesis[name].columns)
    some = [f for f in forms if f in shown and desk.pays(_shaken(best, name, f), best)]
    return reforms(best, desk, name, some)


def _shaken(best: Fit, name: str, form: str) -> float:
    """What an effect gains in such a form before it is fitted."""
    there = (score(costed(best.context, start)) for start in _starts(best, name, form))
    return score(best) - min(there, default=np.inf)


def _groups(best: Fit, desk: Desk, shaking: bool, early: bool = False) -> Iterator[Group]:
    make = _mending if early else reforms
    for name, term in best.hypothesis.items():
        kind = effect(name)
        forms = [f for f in kind.forms if f != term.form and (f in kind.shaking) == shaking]
        columns = best.context.judged(term)
        others = [form for form in forms if form != kind.apart]
        if others and columns:
            yield Group(name, columns, partial(make, best, desk, name, others))
        if kind.apart in forms and columns:
            trials, promise = partial(reforms, best, desk, name, [kind.apart]), partial(_promise, best, name)
            yield Group((name, kind.apart), columns, trials, promise)


def _promise(best: Fit, name: str) -> float:
    """What values of each joint's own may gain by a linear look, less what they cost."""
    apart = best.hypothesis.reformed(name, effect(name).apart)
    screen = Screen(best.context, apart, apart[name].columns)
    gain = sum(best.cost[c] - screen.left(c) for c in apart[name].columns if c in best.cost)
    further = priced(Fit(apart, best.cost, best.context)) - priced(best)
    return gain / PROMISED - max(further, 0.0)


def reforms(best: Fit, desk: Desk, name: str, forms: Sequence[str]) -> Iterator[Fit]:
    """An effect in each of some forms that its joints can show, without what it then does by itself: a link
    that swings behind a lag is one that is damped against the arm.
    """
    kind = effect(name)
    shown = shown_forms(kind, best.context, best.hypothesis[name].columns)
    for form in forms:
        if form in shown and kind.own_parameters(form):
            trial = _reformed(best, name, form, _goal(best, name, form))
            if trial is not None:
                yield descend_with(trial, (DROP,), desk) if trial.total < score(best) else trial


def _goal(best: Fit, name: str, form: str) -> float:
    """What squared residuals have to come to, if all else on the effect's joints is not needed any more."""
    there = best.hypothesis.reformed(name, form)
    for column in there[name].columns:
        there = there.less([term.effect for term in there.on(column) if term.effect != name], column)
    return score(best) - prices(best.context, there)


def _reformed(now: Fit, name: str, form: str, goal: float) -> Fit | None:
    """In another form on the joints that it is on; a refined one leaves the values of a joint as they are
    where its motion does not show more.
    """
    context, kind, old = now.context, effect(name), now.hypothesis[name]
    starts = _starts(now, name, form)
    if not starts:
        return None
    if form in kind.shaking:  # a fit of all joints together is dear
        starts = [min(starts, key=lambda start: score(costed(context, start)))]
    trial = min((refit(context, start, goal) for start in starts), key=score)
    if not _refines(kind, old.form, form):
        return trial
    for column in hidden(trial.context, trial.hypothesis[name]):
        kept = trial.hypothesis.copy()
        kept[name].have(column, old.own[column])
        trial = refit_column(trial, kept, column)
    return trial


def _starts(now: Fit, name: str, form: str) -> list[Hypothesis]:
    """Where an effect in a form may begin: each joint at what a linear look finds best, and at the values
    that it has; none where no joint shows it.
    """
    begun = _begun(now, name, form)
    if begun is None:
        return []
    if _refines(effect(name), now.hypothesis[name].form, form):
        return [begun, *refinements(now.hypothesis, name, form)]
    there = now.hypothesis.reformed(name, form)
    used = {p.name for p in effect(name).own_parameters(form) if not p.optional}
    return [begun, there] if all(used <= there[name].values(c).keys() for c in there[name].own) else [begun]


def _refines(kind: type[Effect], old: str, new: str) -> bool:
    return new in kind.refined and old not in kind.refined


def _begun(now: Fit, name: str, form: str) -> Hypothesis | None:
    """Each joint at what a linear look finds best; but for joints that do not show it, as may be where it
    stood for something else. Those that can not be judged keep what they have, and all their form if the
    other one has no place for that.
    """
    kind, old, out = effect(name), now.hypothesis[name], now.hypothesis.without(name)
    judged = now.context.judged(old)
    for column in judged:
        out = begun_on(now.context, out, kind, form, [column]) or out
    if name not in out or (name in now.context.known and set(judged) - out[name].own.keys()):
        return None
    used = {p.name for p in kind.used(form)}
    for column in old.own.keys() - set(judged):
        if old.own[column].keys() - used:
            return None
        out.have(column, replace(old, own={column: old.shared | old.own[column]}))
    out[name].shared |= {
        p.name: old.shared[p.name] for p in kind.own_parameters(form) if p.optional and p.name in old.shared
    }
    return out


def refinements(hypothesis: Hypothesis, name: str, form: str) -> Iterator[Hypothesis]:
    """An effect with the values that it has, and what a refined form adds at each of its start values."""
    known = effect(name).own_parameters(hypothesis[name].form)
    added = [p for p in effect(name).own_parameters(form) if p not in known]
    for k in range(max((len(p.scan) for p in added), default=0)):
        out = hypothesis.reformed(name, form)
        for parameter in added:
            start = parameter.scan[k % len(parameter.scan)] if parameter.scan else parameter.typical
            for values in [out[name].shared] if parameter.shared else out[name].own.values():
                values[parameter.name] = start
        yield out


FORM = Move("form", groups, descends=True, settles=True)
SHAKE = Move("shake", shaking_groups, descends=True, cheap=True)
