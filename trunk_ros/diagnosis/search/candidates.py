"""Which effects may be tried where."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.effects import Effect, effect, registry

OWN = 4  # local effects on one joint
OTHERS = "several"  # what an effect needs that has one joint moved by others
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

    @property
    def lasts(self) -> bool:
        """Whether it begins, ends or changes its size in mid-run."""
        return any(m.name in self.start for m in effect(self.effect).moments())


def what_it_has(context: Context) -> dict[str, bool]:
    """By what an effect may need, whether an arm and its recording have it."""
    arm = context.arm
    return {
        "load": context.stage.has_load,
        "weight": arm.has_load,
        "effort": context.stage.load_recorded,
        "dead_band": bool(np.sum(arm.dead_band[context.columns] > 0) > 1),
        OTHERS: len(arm.joints) > 1 and not context.alone,
    }


def usable(context: Context) -> list[type[Effect]]:
    """The named effects of the stage that this arm can have and this recording can show."""
    has = what_it_has(context)
    unseen = () if context.speed_tells else DYNAMIC
    motions = {context.motion(c) for c in context.columns}
    return [
        kind
        for name, kind in registry().items()
        if kind.stage == context.stage.name
        and kind.named
        and kind.tried
        and kind.regime not in unseen
        and all(has[need] for need in kind.needs)
        and any(map(kind.forms_shown, motions))
    ]


def shown_forms(kind: type[Effect], context: Context, columns: Iterable[int]) -> tuple[str, ...]:
    """The forms that some joints may show, all those of them that may show any."""
    shown = [forms for c in columns if (forms := kind.forms_shown(context.motion(c)))]
    return tuple(f for f in kind.forms if shown and all(f in each for each in shown))


def plain_forms(kind: type[Effect], context: Context, columns: Iterable[int]) -> tuple[str, ...]:
    """The same but for those that are looked at once another has been found."""
    return tuple(f for f in shown_forms(kind, context, columns) if f not in kind.refined)


def local_kinds(context: Context) -> list[type[Effect]]:
    """Effects that a single joint may have."""
    return [k for k in usable(context) if not k.everywhere]


def kinds_of_all(context: Context, hypothesis: Hypothesis) -> list[type[Effect]]:
    """Effects that act on all joints, and are not there."""
    return [k for k in usable(context) if k.everywhere and k.id not in hypothesis]


def open_kinds(context: Context, hypothesis: Hypothesis, column: int) -> list[type[Effect]]:
    """Effects of its own that a column may have besides those that it has; beside a curve there is room for
    none.
    """
    own = [t for t in hypothesis.on(column) if not effect(t.effect).everywhere]
    if len(own) >= OWN or any(not effect(t.effect).named for t in own):
        return []
    return [k for k in local_kinds(context) if is_open(context, hypothesis, k, column)]


def is_open(context: Context, hypothesis: Hypothesis, kind: type[Effect], column: int) -> bool:
    """Whether an effect may be added on a column."""
    if not kind.forms_shown(context.motion(column)):
        return False
    if kind.id in hypothesis and column in hypothesis[kind.id].own:
        return 0 < len(hypothesis.get_words(kind.id, column)) < len(kind.texts)
    return not any(kind.id in effect(other).replaces for other in hypothesis)


def breaking_kinds(context: Context, hypothesis: Hypothesis, column: int) -> list[type[Effect]]:
    """Effects that act on all joints alike as a rule, but may begin on one: a wire that gives way."""
    return [
        k
        for k in kinds_of_all(context, hypothesis)
        if k.begins and not k.own_parameters(k.forms[0])[0].shared
        if is_open(context, hypothesis, k, column) and not taken(k, hypothesis, column)
    ]


def own_effects(hypothesis: Hypothesis, column: int) -> list[str]:
    """Effects that a joint has of its own, or by values of its own."""
    return [t.effect for t in hypothesis.on(column) if not effect(t.effect).everywhere or _by_itself(t)]


def _by_itself(term: Term) -> bool:
    """Whether each joint has a size of its own, which no description states."""
    return not term.given and not effect(term.effect).own_parameters(term.form)[0].shared


def extended(context: Context, hypothesis: Hypothesis, candidate: Candidate) -> Hypothesis:
    """The hypothesis with a candidate added at its start values."""
    out = hypothesis.copy()
    kind = effect(candidate.effect)
    columns = (candidate.columns or context.columns) if candidate.column is None else [candidate.column]
    if kind.bears(candidate.form):
        columns = [c for c in columns if context.stage.bears(c) and kind.forms_shown(context.motion(c))]
    for rival in replaced(kind, out):
        del out[rival]
    term = out.setdefault(candidate.effect, Term(candidate.effect, candidate.form))
    for column in columns:
        if column in term.own and kind.texts:
            _add_source(term, kind, column, candidate.start)
        else:
            free = candidate.free or bool(term.own and not term.given)
            _add(term, kind, context, column, candidate.own.get(column, candidate.start), free)
            if kind.beyond in out and column in context.wide:
                _take_off(out[kind.beyond], term, column)
    return out


def replaced(kind: type[Effect], hypothesis: Hypothesis) -> list[str]:
    """The effects of a hypothesis that include another or are included in it."""
    return [name for name in hypothesis if name in kind.replaces or kind.id in effect(name).replaces]


def taken(kind: type[Effect], hypothesis: Hypothesis, column: int) -> bool:
    """Whether a column has another effect that includes the same one, as a slack wire and a stiff one do."""
    others = [effect(term.effect) for term in hypothesis.on(column) if term.effect != kind.id]
    return any(set(kind.replaces) & set(other.replaces) for other in others)


def _take_off(flat: Term, rounded: Term, column: int) -> None:
    """Let a rounded part of a wide loop begin in the place of as much of its flat part."""
    name, lead = (effect(t.effect).parameters[0].name for t in (flat, rounded))
    if column in flat.own:
        flat.own[column][name] = max(flat.own[column][name] - rounded.own[column][lead] / 2, 0.0)


def _add(
    term: Term, kind: type[Effect], context: Context, column: int, start: dict[str, Any], free: bool
) -> None:
    known = given(kind, context) if kind.everywhere and not free else {}
    own = term.own.setdefault(column, {})
    for parameter in kind.used(term.form):
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


def given(kind: type[Effect], context: Context) -> dict[str, Array]:
    """Parameter values that the arm's own description states, so that a fit need not free them."""
    stated = {p.name: getattr(context.arm, p.stated) for p in kind.parameters if p.stated}
    return {name: values for name, values in stated.items() if len(values)}


def another_law(known: Term, now: Term) -> bool:
    """Whether an effect goes by another form than it did, and not only by values of each joint's own."""
    return known.form != now.form and effect(now.effect).apart not in (known.form, now.form)
