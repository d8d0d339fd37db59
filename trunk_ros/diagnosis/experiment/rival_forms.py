"""Both sides of a pair of rivals: each taken for the truth, in the forms that explain the recordings."""

from __future__ import annotations

import numpy as np

from trunk_ros.diagnosis.evidence.evidence import Evidence, doubt
from trunk_ros.diagnosis.evidence.rivals import by_its_own_angles
from trunk_ros.diagnosis.experiment.discrimination import Duel, Other
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.effects import effect
from trunk_ros.levels import REFITTED
from trunk_ros.parameter import Parameter


def sides_of(state: Fit, name: str, rival: str, evidence: Evidence) -> list[Duel]:
    """What was found taken for the truth, then each form of the rival taken for it: one effect may be able to
    turn into the other, and then only one of the two can be ruled out.
    """
    limit = doubt(state, evidence.gain)
    others = forms_of(state, evidence.fitted[rival], rival, limit)
    own = forms_of(state, state.hypothesis, name, limit)
    forward = Duel(name, rival, Other(state.context, state.hypothesis, 0.0), others)
    return [forward, *(Duel(rival, name, other, own) for other in others)]


def forms_of(state: Fit, there: Hypothesis, name: str, limit: float) -> list[Other]:
    """An effect in the forms and with the sources that lose less than ``limit`` against ``state``, best
    first; the best one whatever it loses. All joints are of one form.
    """
    kind, context = effect(name), state.context
    trials = [in_form(there, name, form) for form in kind.forms if kind.own_parameters(form)]
    if kind.texts:
        trials += [from_source(there, name, joint, context.joints) for joint in context.joints]
    tried: list[Fit] = []
    for trial in trials or [there]:
        least = min((fit.total for fit in tried), default=np.inf)
        tried.append(refit(context, trial, max(least, state.total + limit)))
    tried = [by_its_own_angles(state, fit.hypothesis) or fit for fit in tried]
    fits = sorted(tried, key=lambda fit: fit.total)
    close = [fit for fit in fits[1:REFITTED] if fit.total - state.total < limit]
    return [Other(context, fit.hypothesis, fit.total - state.total) for fit in [fits[0], *close]]


def from_source(hypothesis: Hypothesis, name: str, source: str, joints: tuple[str, ...]) -> Hypothesis:
    """An effect that another joint causes, wherever it is not that joint itself."""
    out, first = hypothesis.copy(), effect(name).texts[0]
    for column, words in out[name].words.items():
        if joints[column] != source and source not in words.values():
            words[first] = source
    return out


def in_form(hypothesis: Hypothesis, name: str, form: str) -> Hypothesis:
    """An effect in one form on all its joints, from the values that it has; others from their usual ones."""
    out = hypothesis.copy()
    term, needed = out[name], effect(name).own_parameters(form)
    term.form = form
    term.shared = {
        p.name: term.shared.get(p.name, p.typical) for p in needed if p.shared and _has(p, term.shared)
    }
    term.own = {
        c: {p.name: own.get(p.name, p.typical) for p in needed if not p.shared and _has(p, own)}
        for c, own in term.own.items()
    }
    return out


def _has(parameter: Parameter, values: dict[str, float]) -> bool:
    return not parameter.optional or parameter.name in values
