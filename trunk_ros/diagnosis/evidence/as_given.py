"""What the model has stays as it is where the recording does not tell another value: a fit moves every value,
and of one that the motion hardly shows it makes whatever the noise asks for.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.score import naming, need
from trunk_ros.effects import effect
from trunk_ros.effects.bank import Bank


def as_given(state: Fit) -> Fit:
    """With the values of the model, of each effect that it has joint by joint and of what joints share, where
    others explain less than an effect has to.
    """
    for name in state.context.known:
        if name in state.hypothesis:
            state = _as_given(state, name)
    return state


def _as_given(state: Fit, name: str) -> Fit:
    known, now, kind = state.context.known[name], state.hypothesis[name], effect(name)
    if not kind.named or issubclass(kind, Bank) or known == now:
        return state
    whole = _held(state, name, known)  # and stays so: what is fitted later would move it again
    if whole.total < state.total + naming(kind.stage) + _need(state, None):
        return whole
    alike = known.form == now.form or kind.apart not in (known.form, now.form)
    for column in (None, *known.columns) if alike else ():
        trial = _held(state, name, back(state.hypothesis[name], known, column))
        state = trial if trial.total < state.total + _need(state, column) else state
    there = replace(state.hypothesis[name], given=now.given)
    return replace(state, hypothesis=Hypothesis({**state.hypothesis, name: there}))


def back(now: Term, known: Term, column: int | None) -> Term:
    """A term with the values of the model on a joint, or those that joints share; what a form has besides
    stays, what happens in mid-run is gone.
    """
    out, kind = now.copy(), effect(now.effect)
    moments = {m.name for m in kind.moments()}
    if column is None:
        options = {p.name for p in kind.parameters if p.optional} | moments
        kept = {n: v for n, v in now.shared.items() if n not in options}
        used = {p.name for p in kind.used(now.form) if p.shared}
        out.shared = kept | {n: v for n, v in known.shared.items() if n in used}
    else:
        had = {n: v for n, v in now.own.get(column, {}).items() if n not in moments}
        out.have(column, had | known.own[column])
        out.words.pop(column, None)
        if column in known.words:
            out.words[column] = dict(known.words[column])
    return out


def _held(state: Fit, name: str, term: Term) -> Fit:
    """What is left with an effect exactly so, and all else fitted."""
    values = frozenset(p.name for p in effect(name).used(term.form))
    return refit(state.context, Hypothesis({**state.hypothesis, name: replace(term.copy(), given=values)}))


def _need(state: Fit, column: int | None) -> float:
    """What an effect has to explain on a joint, or on the usual one."""
    context: Context = state.context
    if column in context.columns:
        return need(context, column, state.rest(column))
    return float(np.median([need(context, c, state.rest(c)) for c in context.columns]))
