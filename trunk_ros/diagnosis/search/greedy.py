"""The search: the first change that pays is taken, until none does or the work that was granted is done."""

from __future__ import annotations

from dataclasses import replace

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.descent import Desk, descend, renewed
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.moves import DROP, MOVES
from trunk_ros.diagnosis.search.score import formed_misfits
from trunk_ros.effects import effect


def search(context: Context, desk: Desk, start: Hypothesis | None = None) -> Fit:
    """The hypothesis that no single change improves by what is needed."""
    best = descend(renewed(begun(context, start)), MOVES, desk)
    claimed = replace(best, context=replace(best.context, claims=True))
    return plain(descend(claimed, (DROP,), desk))


def begun(context: Context, start: Hypothesis | None = None) -> Fit:
    """What is known, fitted; all else is measured by what it leaves."""
    first = refit(context, start or context.known)
    misfit = {c: first.rest(c) for c in first.cost}
    return replace(first, context=replace(first.context, misfit=misfit, formed_misfit=formed_misfits(first)))


def plain(now: Fit) -> Fit:
    """The same physics in the values that one would write down."""
    out = now.hypothesis.copy()
    for term in out.values():
        term.own = {c: effect(term.effect).plain(values) for c, values in term.own.items()}
    return replace(now, hypothesis=out)
