"""A set of effects with values, as a vector that a fit can move."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache, reduce
from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effect_values import Values, payload_in
from trunk_ros.effects import Effect, effect, registry
from trunk_ros.effects.moments import NOTHING, Payload
from trunk_ros.machine import BOUND
from trunk_ros.parameter import Parameter, leading

Numbers = tuple[tuple[str, float], ...]
Words = tuple[tuple[str, str], ...]


class Free(NamedTuple):
    """One number that a fit moves; ``column`` None where it is shared."""

    effect: str
    parameter: Parameter
    column: int | None


@dataclass
class Term:
    """One effect on some joints: values by column, shared values, words, and what is not to be fitted."""

    effect: str
    form: str = ""
    shared: dict[str, float] = field(default_factory=dict)
    own: dict[int, dict[str, float]] = field(default_factory=dict)
    words: dict[int, dict[str, str]] = field(default_factory=dict)
    given: frozenset[str] = frozenset()

    def copy(self) -> Term:
        """A copy whose values can be changed."""
        own = {column: dict(values) for column, values in self.own.items()}
        words = {column: dict(values) for column, values in self.words.items()}
        return Term(self.effect, self.form, dict(self.shared), own, words, self.given)

    def key(self, column: int) -> tuple[str, str, Numbers, Numbers, Words]:
        """What the term does on one joint, for caches."""
        own, words = self.own[column].items(), self.words.get(column, {}).items()
        return (self.effect, self.form, tuple(self.shared.items()), tuple(own), tuple(words))

    @property
    def columns(self) -> list[int]:
        """The joints that the effect is on."""
        return sorted(self.own)

    def reform(self, form: str) -> None:
        """Take another form: what joints shared each then has, what each had they share at its median."""
        self.form, before = form, self.shared
        names = [p.name for p in effect(self.effect).used(form) if p.shared]
        had = {n: [before[n]] if n in before else [v[n] for v in self.own.values() if n in v] for n in names}
        self.shared = {n: float(np.median(v)) for n, v in had.items() if v}
        for column, values in self.own.items():
            self.have(column, {**before, **values})

    def have(self, column: int, values: Mapping[str, float]) -> None:
        """Be on a joint with values that it may have had in another form: those that this one uses."""
        used = {p.name for p in effect(self.effect).used(self.form) if not p.shared}
        self.own[column] = {name: value for name, value in values.items() if name in used}

    def home(self, column: int | None) -> dict[str, float]:
        """The values of a joint's own, or for None those that its joints share."""
        return self.shared if column is None else self.own[column]

    def moments(self, column: int | None) -> tuple[str, ...]:
        """Which of its beginnings and ends on a joint are said; None: of all its joints at once."""
        values = self.home(column)
        return tuple(m.name for m in effect(self.effect).moments() if m.moment and m.name in values)

    @property
    def carried(self) -> list[str]:
        """Which of its values are masses at the tip that it has."""
        return [p.name for p in effect(self.effect).carried() if self.shared.get(p.name)]

    def values(self, column: int) -> dict[str, float]:
        """All values for one joint, the shared ones included."""
        return {**self.shared, **self.own[column]}


class Hypothesis(dict[str, Term]):
    """Effects by ID."""

    def copy(self) -> Hypothesis:
        """A copy whose values can be changed."""
        return Hypothesis({name: term.copy() for name, term in self.items()})

    def on(self, column: int) -> list[Term]:
        """The terms on a joint, in physical order."""
        return [self[name] for name in sorted(self, key=_place) if column in self[name].own]

    def new_on(self, column: int, before: Hypothesis) -> list[Term]:
        """The terms on a joint that it had not ``before``."""
        had = {term.effect for term in before.on(column)}
        return [term for term in self.on(column) if term.effect not in had]

    @property
    def curved(self) -> set[int]:
        """The joints that a curve without a name is on."""
        return {c for name, term in self.items() if not effect(name).named for c in term.columns}

    def bound(self, column: int) -> list[Effect]:
        """The effects on one joint, as blocks over that joint alone."""
        return [bind_column(term, column) for term in self.on(column)]

    def free(self, columns: list[int], judged: Iterable[int] | None = None) -> list[Free]:
        """What a fit of these joints moves; shared values only if it covers all of theirs that are judged."""
        return [f for t in self.values() for f in _free(t, columns, t.own if judged is None else judged)]

    def free_values(self, free: list[Free]) -> Array:
        """The free values, logarithms where the parameter is fitted so."""
        return np.array([_encode(f.parameter, self[f.effect].home(f.column)[f.parameter.name]) for f in free])

    def moved(self, f: Free, x: float) -> Hypothesis:
        """The same with one value ``x`` on the scale of its parameter; other terms are not copied."""
        out = Hypothesis(self)
        out[f.effect] = self[f.effect].copy()
        out.set([f], np.array([x]))
        return out

    def put(self, free: list[Free], x: Array) -> Hypothesis:
        """A copy with the values ``x`` (free,), on the scales of their parameters."""
        out = self.copy()
        out.set(free, x)
        return out

    def set(self, free: list[Free], x: Array) -> None:
        """Take the values ``x`` (free,), on the scales of their parameters."""
        for f, value in zip(free, x, strict=True):
            self[f.effect].home(f.column)[f.parameter.name] = _decode(f.parameter, float(value))

    def get_words(self, name: str, column: int) -> tuple[str, ...]:
        """Words that an effect has on a joint, such as the sources of a coupling."""
        return tuple(self[name].words.get(column, {}).values()) if name in self else ()

    def take(self, column: int, other: Hypothesis) -> None:
        """Have on a column what another hypothesis has there."""
        for term in self.values():
            term.own.pop(column, None)
            term.words.pop(column, None)
        for term in other.on(column):
            self.have(column, term)

    def have(self, column: int, term: Term) -> None:
        """Have an effect on a column as a term has it there; what joints share as far as it is new."""
        mine = self.setdefault(term.effect, Term(term.effect, term.form, dict(term.shared), given=term.given))
        mine.have(column, term.own[column])
        if column in term.words:
            mine.words[column] = dict(term.words[column])

    def key(self, column: int) -> tuple[object, ...]:
        """What a prediction of one joint depends on, for caches."""
        return (payload_of(self), *(term.key(column) for term in self.on(column)))

    def without(self, name: str, column: int | None = None) -> Hypothesis:
        """A copy without an effect, on one joint or at all."""
        out = self.copy()
        if column is not None:
            out[name].own.pop(column, None)
            out[name].words.pop(column, None)
        if column is None or not out[name].own:
            del out[name]
        return out

    def reformed(self, name: str, form: str) -> Hypothesis:
        """A copy with an effect in another form."""
        out = self.copy()
        out[name].reform(form)
        return out

    def less(self, names: Iterable[str], column: int | None = None) -> Hypothesis:
        """A copy without some effects, on one joint or at all."""
        return reduce(lambda out, name: out.without(name, column), names, self)

    @property
    def shakes(self) -> bool:
        """Whether joints move each other by their masses, so that all are computed together."""
        return any(term.form in effect(name).shaking for name, term in self.items())

    def model_effects(self, joints: int) -> dict[str, Values]:
        """The effects as a model holds them."""
        return {name: _model_values(self[name], joints) for name in registry() if name in self}


@cache
def _place(name: str) -> tuple[int, str]:
    """Where an effect acts among those of its stage."""
    return effect(name).place, name


def hypothesis_of(effects: Mapping[str, Values], stage: str, joints: int) -> Hypothesis:
    """The effects that a model of so many joints has in a stage, as terms that a fit can move."""
    there = {name: values for name, values in effects.items() if effect(name).stage == stage}
    return Hypothesis({name: _term_of(effect(name), values, joints) for name, values in there.items()})


def _term_of(kind: type[Effect], values: Values, joints: int) -> Term:
    form = str(values.get("form", kind.forms[0]))
    used = [p for p in kind.used(form) if p.name in values]
    own = [(p, np.broadcast_to(values[p.name], joints)) for p in used if not p.shared]
    alike = not own or leading(kind.own_parameters(form)).shared
    on = [j for j in range(joints) if alike or any(v[j] != p.null for p, v in own)]
    words = {j: {t: values[t][j] for t in kind.texts if t in values and values[t][j]} for j in on}
    return Term(
        kind.id,
        form,
        {p.name: float(values[p.name]) for p in used if p.shared},
        {j: {p.name: float(v[j]) for p, v in own if not p.optional or v[j] != p.null} for j in on},
        {j: said for j, said in words.items() if said},
        frozenset(p.name for p, _ in own) if not kind.named else frozenset(),
    )


def bind_column(term: Term, column: int) -> Effect:
    """A term as a block over one joint."""
    name, *rest = term.key(column)
    return _bound(effect(name), *rest)


@lru_cache(BOUND)
def _bound(kind: type[Effect], form: str, shared: Numbers, own: Numbers, words: Words) -> Effect:
    values = {**kind.null(), **dict(shared), **dict(own)}
    numbers = {name: np.array([value]) for name, value in values.items()}
    return kind(numbers, {name: (word,) for name, word in words}, form)


def bounds(free: list[Free]) -> tuple[Array, Array]:
    """Lower and upper bounds of a free vector."""
    low, high = ([_encode(f.parameter, f.parameter.reach[k]) for f in free] for k in range(2))
    return np.array(low), np.array(high)


def scales(free: list[Free], loads: Array) -> Array:
    """The usual size of each free value on joints that bear ``loads`` (joints,) N m; 1 for logarithms."""
    return np.array([1.0 if f.parameter.scale == "log" else _usual(f, loads) for f in free])


def _usual(free: Free, loads: Array) -> float:
    load = loads.max() if free.column is None else loads[free.column]
    return abs(free.parameter.typical) * free.parameter.under(float(load))


def _free(term: Term, columns: list[int], judged: Iterable[int]) -> Iterator[Free]:
    kind = effect(term.effect)
    for parameter in kind.used(term.form):
        if parameter.name in term.given or parameter.measured:
            continue
        if parameter.shared:
            seen = set(term.own).intersection(judged)
            if parameter.name in term.shared and seen and seen <= set(columns):
                yield Free(term.effect, parameter, None)
        else:
            for column in columns:
                if parameter.name in term.own.get(column, {}):
                    yield Free(term.effect, parameter, column)


def _encode(parameter: Parameter, value: float) -> float:
    return float(np.log(value)) if parameter.scale == "log" else value


def _decode(parameter: Parameter, x: float) -> float:
    low, high = parameter.bounds
    if parameter.periodic:
        return x if low <= x <= high else x - 2.0 * np.pi * round(x / (2.0 * np.pi))
    return min(max(float(np.exp(x)) if parameter.scale == "log" else x, low), high)


def _model_values(term: Term, joints: int) -> Values:
    kind = effect(term.effect)
    values: Values = dict(term.shared)
    for parameter in (*kind.parameters, *kind.moments()):
        if any(parameter.name in own for own in term.own.values()):
            own = [term.own.get(j, {}) for j in range(joints)]
            values[parameter.name] = np.array([each.get(parameter.name, parameter.null) for each in own])
    for text in kind.texts:
        if any(text in words for words in term.words.values()):
            values[text] = [term.words.get(j, {}).get(text, "") for j in range(joints)]
    if term.form:
        values["form"] = term.form
    return values


def payload_of(hypothesis: Hypothesis) -> Payload:
    """Mass at the tip that the terms add; of several that which is not always there says when."""
    there = [payload_in(name, t.shared) for t in hypothesis.values() if t.shared for name in t.carried]
    if not there:  # asked at each prediction
        return NOTHING
    when = next((one for one in there if not one.always), NOTHING)
    return when._replace(mass=float(sum(one.mass for one in there)))
