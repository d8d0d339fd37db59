"""What differs from the model that was given: which of its effects have another size, and which are gone.

Each value is compared once, with its spread: a part of an effect that both have as it was is no finding.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.evidence import SUREST
from trunk_ros.diagnosis.evidence.spreads import Spreads
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import another_law
from trunk_ros.diagnosis.verdict.finding import Finding, evidence_of
from trunk_ros.diagnosis.verdict.findings import ARM, VARIES_WITH, unchanged, value_of
from trunk_ros.effects import Effect, confused, effect
from trunk_ros.effects.bank import Bank
from trunk_ros.levels import HALF, ROUGH, SURE
from trunk_ros.parameter import Parameter
from trunk_ros.units import sized, unit_on

MODEL, SIMULATION = "the model", "your simulation"


@dataclass(frozen=True)
class Value:
    """A value of an effect in the model and in the recording, each null where the effect is not there."""

    parameter: Parameter
    label: str
    theirs: float
    seen: float
    std: float | None
    unit: str
    size: bool
    """Whether the effect is there as far as this is."""

    @property
    def same(self) -> bool:
        """Whether the two are one within the spread, or the data do not tell."""
        if self.std is None and not self.size and not self.parameter.optional:
            return True
        if self.theirs == self.parameter.null:
            return self.none
        return unchanged({"value": self.seen, "std": self.std}, self.theirs)

    @property
    def apart(self) -> float:
        """How far the two are from each other, in standard deviations; 0 where these are not known."""
        return abs(self.seen - self.theirs) / self.std if self.std else 0.0

    @property
    def none(self) -> bool:
        """Whether nothing is seen of it, beside what the model has."""
        null = self.parameter.null
        return abs(self.seen - null) <= max(ROUGH * abs(self.theirs - null), SURE * (self.std or 0.0))

    @property
    def nothing(self) -> bool:
        """Whether neither has any of it."""
        return self.none and self.theirs == self.parameter.null

    def told(self, who: str) -> str:
        """In words."""
        theirs, seen = sized(self.theirs, self.unit), sized(self.seen, self.unit)
        words, null = self.label, self.parameter.null
        if self.none:
            return f"{words}{who} has {theirs}, the recording shows none"
        if self.theirs == null:
            return f"{words}{who} has none, the recording shows {seen}"
        if null != 0.0 or self.theirs * self.seen < 0.0 or self.parameter.moment:
            much = "another value"
        else:
            more = abs(self.seen) > abs(self.theirs)
            much = f"{sized(abs(self.seen - self.theirs), self.unit)} too {'little' if more else 'much'}"
        return f"{words}{who} has {theirs}, the recording shows {seen} ({much})"


def changes(
    context: Context, hypothesis: Hypothesis, every: Sequence[Finding], std: Spreads, who: str
) -> list[Finding]:
    """Findings; those on effects that the model has as what differs from it. ``who`` has the model's: where
    that is another simulator, values are differences.
    """
    named = {n: t for n, t in context.known.items() if effect(n).named and not issubclass(effect(n), Bank)}
    new = [f for f in every if f.effect not in named]
    there, parts = dict(hypothesis), {effect(n).includes.get(t.form) for n, t in hypothesis.items()}
    for name, term in named.items():
        found = next((f for f in every if f.effect == name), None)
        now, spreads = _carried_on(term, there, std)
        told_besides = name in parts or (now is not None and now.form in effect(name).includes)
        law = now is not None and not told_besides and another_law(term, now)
        changed = _changed(context, term, now, found, spreads, who, law)
        if changed is not None:
            beside = [f for f in new if f.effect not in named]
            new.append(changed if name in hypothesis and _measured(changed) else _beside(changed, beside))
    return new


def _carried_on(known: Term, there: dict[str, Term], std: Spreads) -> tuple[Term | None, Spreads]:
    """An effect of the model as it is now, with standard deviations: also where another law, with its values
    and more, has taken its place on a joint.
    """
    now, name = there.get(known.effect), known.effect
    lead = effect(name).own_parameters(known.form)[0]
    for other, term in there.items():
        columns = [c for c in term.columns if c in known.own and (now is None or c not in now.own)]
        if not columns or lead not in effect(other).used(term.form):
            continue
        now = Term(name, known.form, dict(term.shared)) if now is None else now.copy()
        for c in columns:
            now.have(c, term.own[c])
        std = {(name, *key[1:]): value for key, value in std.items() if key[0] == other} | std
    return now, std


def _changed(
    context: Context, known: Term, now: Term | None, found: Finding | None, std: Spreads, who: str, law: bool
) -> Finding | None:
    """``law``: whether it goes by another form."""
    kind = effect(known.effect)
    if found is not None and now is not None and _size(known) != _size(now):
        return found  # forms whose sizes have nothing to do with each other
    if now is not None and known.form != now.form and kind.apart in (known.form, now.form):
        known, now = _joint_by_joint(known), _joint_by_joint(now)
    parameters: dict[str, dict[str, dict[str, Any]]] = {}
    said, gone = [], True
    owners = [(ARM, None), *((context.joints[c], c) for c in context.columns)]
    every = {owner: list(_values(context, known, now, column, std)) for owner, column in owners}
    each = {owner: _differing(values) for owner, values in every.items()}
    together = found is not None and not law and not any(each.values())
    if together:
        each = _farthest(every)
    for owner, values in every.items():
        none, differ = _is_none(values), each[owner]
        if not differ:
            continue
        told = {} if none or found is None else dict(found.parameters.get(owner, {}))
        for value in differ:
            told[value.parameter.name] = _entry(value, who)
        parameters[owner], gone = told, gone and none
        said.append(f"{owner}: {', '.join(value.told(who) for value in differ)}")
    if not parameters and (found is None or not law):
        return None
    if law and found is not None and now is not None and not (parameters and gone):
        where = "" if parameters else f"{', '.join(found.joints)}: "
        said.insert(0, f"{where}{who} has the form {known.form}, the recording shows {now.form}")
        parameters, gone = parameters or found.parameters, False
    joints = [joint for joint in context.joints if joint in parameters]
    joints = joints or (found.joints if found else [context.joints[c] for c in context.columns])
    what = kind.title((now or known).form)
    statement = f"{what[0].lower()}{what[1:]}: {'; '.join(said)}."
    base = _gone(known) if found is None or gone else found
    if together:  # which of them it is, is a guess
        base = replace(base, confidence=min(base.confidence, HALF))
    return replace(base, joints=joints, parameters=parameters, statement=statement)


def _is_none(values: Sequence[Value]) -> bool:
    """Whether a joint has sizes, and nothing is seen of any."""
    return all(v.none for v in values if v.size) and any(v.size for v in values)


def _differing(values: Sequence[Value]) -> list[Value]:
    """Those of a joint that are surely not the model's."""
    none = _is_none(values)
    return [v for v in values if not v.same and (v.size or not none) and not v.nothing]


def _farthest(every: dict[str, list[Value]]) -> dict[str, list[Value]]:
    """Of values of which each alone may be the model's, though all together are not (``as_given`` would have
    put them back), that which is farthest from it in its own spread.
    """
    apart = {id(v): v.apart for values in every.values() for v in values}
    most = max(apart.values(), default=0.0)
    return {owner: [v for v in values if apart[id(v)] == most > 0.0] for owner, values in every.items()}


def _joint_by_joint(term: Term) -> Term:
    """The same in the form in which each joint has values of its own."""
    out = term.copy()
    out.reform(effect(term.effect).apart)
    return out


def _size(term: Term) -> str:
    return effect(term.effect).own_parameters(term.form)[0].name


def _values(
    context: Context, known: Term, now: Term | None, column: int | None, std: Spreads
) -> Iterator[Value]:
    """The values of an effect on a joint, or those that all joints share; but for its size only where both
    have it.
    """
    kind, name = effect(known.effect), known.effect
    old, new = _of(known, column), _of(now, column)
    joint = "rad" if column is None else context.stage.unit(column)
    gains = _gains(known, now, column)
    for source, (gain, was, there) in gains.items():
        unit = unit_on(gain, joint)
        yield Value(gain, f"of {source} ", was, there, std.get((name, gain.name, column)), unit, True)
    form, both = (now or known).form, now is not None and all(_on(term, column) for term in (known, now))
    for p in kind.used(form):
        if p.shared != (column is None) or (p.name not in old and p.name not in new) or _has_a_word(kind, p):
            continue
        size = p == kind.own_parameters(form)[0]
        if size or both:
            theirs, seen = (values.get(p.name, p.null) for values in (old, new))
            label = "" if size else f"{p.name}: "
            spread = std.get((name, p.name, column), std.get((name, p.name, None)))
            yield Value(p, label, theirs, seen, spread, unit_on(p, joint), size)


def _of(term: Term | None, column: int | None) -> dict[str, float]:
    if term is None:
        return {}
    return term.shared if column is None else term.own.get(column, {})


def _on(term: Term, column: int | None) -> bool:
    """Whether an effect is on a joint, or anywhere."""
    return column is None or column in term.own


def _has_a_word(kind: type[Effect], parameter: Parameter) -> bool:
    """Whether a value belongs to a word, such as a gain to its source."""
    return parameter in kind.parameters[: len(kind.texts)]


def _gains(known: Term, now: Term | None, column: int | None) -> dict[str, tuple[Parameter, float, float]]:
    """By source of an effect on a joint: the parameter, what the model has of it and what is seen."""
    kind, out = effect(known.effect), dict[str, tuple[Parameter, float, float]]()
    for seen, term in enumerate((known, now)):
        words = {} if term is None or column is None else term.words.get(column, {})
        for p, text in zip(kind.parameters, kind.texts, strict=False):
            if source := words.get(text, ""):
                value = _of(term, column).get(p.name, p.null)
                out[source] = (
                    (p, out[source][1], value)
                    if seen and source in out
                    else ((p, p.null, value) if seen else (p, value, p.null))
                )
    return out


def _entry(value: Value, who: str) -> dict[str, Any]:
    """As diagnosis.json has it: where another simulator is meant, the effect's size is the difference."""
    apart = who == SIMULATION and value.size and value.parameter.null == 0.0
    size = value.seen - value.theirs if apart else value.seen
    both = {"simulation": value.theirs, "recording": value.seen}
    return {**value_of(size, value.std, value.unit), **both}


def _gone(known: Term) -> Finding:
    """A finding on an effect that the recording does not show at all."""
    kind = effect(known.effect)
    evidence = evidence_of(signature=kind.signature, form=known.form)
    varies = list(VARIES_WITH[kind.regime])
    return Finding(kind.id, kind.stage, [], kind.regime, SUREST, [], {}, varies, "", evidence)


def _measured(changed: Finding) -> bool:
    """Whether the spread of each value that is not the model's is known, beside all that was found."""
    values = [value for each in changed.parameters.values() for value in each.values()]
    return all(value["std"] is not None for value in values)


def _beside(changed: Finding, new: Sequence[Finding]) -> Finding:
    """What is gone is as sure as that which may only have taken its place."""
    alike = [f for f in new if f.effect in confused(changed.effect) and set(f.joints) & set(changed.joints)]
    if changed.evidence["gain"] or not alike:
        return changed
    sure = min(f.confidence for f in alike)
    return replace(changed, confidence=sure, equivalents=[f.effect for f in alike])
