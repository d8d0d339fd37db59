"""Which effects may be tried where."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.hypothesis import Explanation, Term
from trunk_ros.diagnosis.stage import Problem
from trunk_ros.effects import Effect, effect, registry

DYNAMIC = ("high_speed", "low_speed", "hold")  # what a recording that stops to measure cannot show


@dataclass(frozen=True)
class Candidate:
    """An effect to try: on one column, or on all where ``column`` is None; ``gain`` is what a linear look
    promises.
    """

    effect: str
    form: str
    column: int | None
    start: dict[str, Any]
    gain: float = 0.0
    columns: tuple[int, ...] = ()
    """Where ``column`` is None: the joints that would gain, if not all."""
    own: dict[int, dict[str, Any]] = field(default_factory=dict)
    """Start values of joints that begin elsewhere than at ``start``."""
    free: bool = False
    """Fit also what the arm's description states."""


def usable(problem: Problem) -> list[type[Effect]]:
    """The named effects of the stage that this arm can have and this recording can show."""
    arm = problem.arm
    has = {
        "load": problem.has_load,
        "weight": arm.has_load,
        "dead_band": bool(np.sum(arm.dead_band[problem.columns] > 0) > 1),
        "several": len(arm.joints) > 1,
    }
    unseen = () if problem.speed_tells else DYNAMIC
    return [
        kind
        for name, kind in registry().items()
        if kind.stage == problem.stage
        and kind.named
        and kind.tried
        and kind.regime not in unseen
        and all(has[need] for need in kind.needs)
    ]


def seen_forms(problem: Problem, kind: type[Effect], column: int) -> tuple[str, ...]:
    """The forms of an effect that a joint's motion can show: in a wide loop what is flat is a dead band."""
    forms = (kind.rising or kind.forms) if column in problem.wide else kind.forms
    chain = problem.arm.has_load and len(problem.joints) > 1
    return forms if chain else tuple(form for form in forms if form not in kind.weighed)


def extended(problem: Problem, explanation: Explanation, candidate: Candidate) -> Explanation:
    """The explanation with a candidate added at its start values."""
    out = explanation.copy()
    kind = effect(candidate.effect)
    columns = (candidate.columns or problem.columns) if candidate.column is None else [candidate.column]
    if "load" in kind.needs:
        columns = [column for column in columns if problem.bears(column)]
    for rival in replaced(kind, out):
        del out[rival]
    term = out.setdefault(candidate.effect, Term(candidate.effect, candidate.form))
    for column in columns:
        if column in term.own and kind.texts:
            _add_source(term, kind, column, candidate.start)
        else:
            free = candidate.free or bool(term.own and not term.given)
            _add(term, kind, problem, column, candidate.own.get(column, candidate.start), free)
            if kind.beyond in out and column in problem.wide:
                _take_off(out[kind.beyond], term, column)
    return out


def replaced(kind: type[Effect], explanation: Explanation) -> list[str]:
    """The effects of an explanation that include another or are included in it."""
    return [name for name in explanation if name in kind.replaces or kind.id in effect(name).replaces]


def taken(kind: type[Effect], explanation: Explanation, column: int) -> bool:
    """Whether a column has another effect that includes the same one, as a slack wire and a stiff one do."""
    others = [effect(term.effect) for term in explanation.on(column) if term.effect != kind.id]
    return any(set(kind.replaces) & set(other.replaces) for other in others)


def _take_off(flat: Term, rounded: Term, column: int) -> None:
    """Let a rounded part of a wide loop begin in the place of as much of its flat part."""
    name, lead = (effect(t.effect).parameters[0].name for t in (flat, rounded))
    if column in flat.own:
        flat.own[column][name] = max(flat.own[column][name] - rounded.own[column][lead] / 2, 0.0)


def _add(
    term: Term, kind: type[Effect], problem: Problem, column: int, start: dict[str, Any], free: bool
) -> None:
    known = given(kind, problem) if kind.everywhere and not free else {}
    own = term.own.setdefault(column, {})
    for parameter in kind.own_parameters(term.form):
        if parameter.name in known:
            own[parameter.name] = float(known[parameter.name][column])
            term.given |= {parameter.name}
        elif parameter.name in start:
            value = float(start[parameter.name])
            if parameter.shared:
                term.shared.setdefault(parameter.name, value)
            else:
                own[parameter.name] = value
    words = {text: str(start[text]) for text in kind.texts if text in start}
    if words:
        term.words[column] = words


def _add_source(term: Term, kind: type[Effect], column: int, start: dict[str, Any]) -> None:
    """A further source of a joint that already has one."""
    taken = len(term.words[column])
    if taken < len(kind.texts):
        term.own[column][kind.parameters[taken].name] = float(start[kind.parameters[0].name])
        term.words[column][kind.texts[taken]] = str(start[kind.texts[0]])


def given(kind: type[Effect], problem: Problem) -> dict[str, Array]:
    """Parameter values that the arm's own description states, so that a fit need not free them."""
    if "compliance" in {p.name for p in kind.parameters} and len(problem.arm.compliance):
        return {"compliance": problem.arm.compliance}
    return {}
