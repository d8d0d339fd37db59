"""The values of effects as a model holds them, and effects made of them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from trunk_ros.arm.parameters import ANY_JOINTS
from trunk_ros.compiled import Array
from trunk_ros.effects import Effect, effect
from trunk_ros.effects.moments import LASTING, NULLS, Payload, share
from trunk_ros.errors import ModelError
from trunk_ros.parameter import SPELLS, Parameter, spell

Values = dict[str, Any]
"""Of one effect: (joints,) by parameter, a float where it is shared; words as lists; ``form``."""


def bind(name: str, values: Values, joints: tuple[str, ...]) -> Effect:
    """An effect over all joints from a model's values. Raises ModelError for words that name none of them."""
    kind = effect(name)
    numbers: dict[str, Array] = {
        p.name: np.broadcast_to(np.asarray(values.get(p.name, p.null), dtype=float), (len(joints),)).copy()
        for p in (*kind.parameters, *(m for m in kind.moments() if m.name in values))
    }
    block = kind(
        numbers,
        {text: tuple(values[text]) for text in kind.texts if text in values},
        str(values.get("form", "")),
    )
    if joints != (ANY_JOINTS,):
        block.check(joints)
    return block


def effect_values(kind: type[Effect], given: Mapping[str, Any], joints: tuple[str, ...]) -> Values:
    """All values of one effect that a model has of it; empty where everything is at its null."""
    form = kind.form_of(str(given.get("form") or ""))
    numbers = {
        p.name: np.atleast_1d(np.asarray(given.get(p.name, p.null), dtype=float))
        for p in (*kind.parameters, *kind.moments())
    }
    used = {p.name: p for p in kind.used(form)}
    set_ = {p.name for p in kind.parameters if np.any(numbers[p.name] != p.null)}
    if not set_:
        return {}
    _check_form(kind, form, set_)
    set_ |= {m.name for m in kind.moments() if np.any(numbers[m.name] != m.null)}
    values: Values = {"form": form} if len(kind.forms) > 1 else {}
    for p in (*kind.parameters, *kind.moments()):
        if numbers[p.name].size not in (1, len(joints)):
            there = (
                "no joints: name them in arm.joints" if joints == (ANY_JOINTS,) else f"{len(joints)} joints"
            )
            raise ModelError(f"effects.{kind.id}.{p.name} has {numbers[p.name].size} values for {there}")
        if p.name in set_ or (p.name in used and not p.moment and not p.optional):
            values[p.name] = _held(kind, used[p.name], numbers[p.name], len(joints))
    values |= {
        text: spread_over(list(given[text]), len(joints)) for text in kind.texts if any(given.get(text, []))
    }
    _check_moments(kind, values)
    bind(kind.id, values, joints)
    return values


def _check_moments(kind: type[Effect], values: Values) -> None:
    """Raise ModelError for a size, or an end, of what is not said to begin again."""
    for begins, *others in (spell(number) for number in range(2, SPELLS + 1)):
        for before in ("", *(f"{p.name}_" for p in kind.carried())):
            for one in (before + other.name for other in others):
                if one in values and before + begins.name not in values:
                    raise ModelError(f"effects.{kind.id}.{one} needs {before}{begins.name}: from when on?")


def _held(kind: type[Effect], parameter: Parameter, numbers: Array, joints: int) -> Any:
    """A value as a model has it. Raises ModelError for several of what a form shares."""
    if not parameter.shared:
        return spread_over(numbers, joints)
    if numbers.size > 1 and parameter.name in NULLS:
        raise ModelError(f"effects.{kind.id}.{parameter.name} is of all joints at once: give 1 value")
    if numbers.size > 1:
        raise ModelError(
            f"effects.{kind.id}.{parameter.name} has {numbers.size} values: give 1, or form: {kind.apart}"
        )
    return float(numbers[0])


def _check_form(kind: type[Effect], form: str, names: set[str]) -> None:
    """Raise ModelError where a value is set that a form does not have."""
    for name in sorted(names - {p.name for p in kind.own_parameters(form)}):
        having = [f for f in kind.forms if any(p.name == name for p in kind.own_parameters(f))]
        raise ModelError(
            f"effects.{kind.id}.{name} is no value of its form {form!r}: set form to {' or '.join(having)}, "
            f"or leave {name} out"
        )


def check_rivals(effects: Mapping[str, Values]) -> None:
    """Raise ModelError where one effect includes another that a joint has as well."""
    for name in effects:
        for other in effect(name).replaces:
            if other in effects and np.any(_acts(name, effects) & _acts(other, effects)):
                raise ModelError(f"effects.{name} includes effects.{other}: leave one of them out")


def _acts(name: str, effects: Mapping[str, Values]) -> Any:
    """(joints,) where an effect has values of its own that are not null; everywhere if all are shared."""
    own = [p for p in effect(name).parameters if np.ndim(effects[name].get(p.name, 0.0))]
    return np.any([effects[name][p.name] != p.null for p in own], axis=0) if own else np.True_


def spread_over(values: Any, joints: int) -> Any:
    """One value or word stands for all joints; shared values stay as they are."""
    if isinstance(values, list):
        return values * joints if len(values) == 1 else values
    if isinstance(values, np.ndarray):
        return np.broadcast_to(values, (joints,)).copy() if len(values) == 1 else values
    return values


def at_end(name: str, values: Values, duration: float, joints: tuple[str, ...]) -> Values:
    """An effect as it is at the end of a recording of so many seconds, for good; empty where it is gone."""
    kind = effect(name)
    moments = {m.name for m in kind.moments()} & set(values)
    if not moments:
        return values
    left = {key: value for key, value in values.items() if key not in moments}
    at = np.array([duration])
    acts = share(at, values, max(np.size(values[name]) for name in moments))[0]
    size = np.where(acts == 0.0, 1.0, acts)
    for p in (p for p in kind.parameters if p.name in left):
        there = (acts != 0.0) * (size if p.name in kind.sizes else 1.0)
        if p.carried:
            there = payload_in(p.name, {**values, p.name: 1.0}).at(at)[0, 0]
        if np.ndim(left[p.name]) or np.size(there) == 1:
            left[p.name] = np.asarray(p.null + there * (left[p.name] - p.null))[()]
    if not kind.sizes and np.any(size != 1.0):  # only what comes out of it is another one
        again, _, times = (p.name for p in spell(2))
        left |= {again: 0.0 * size, times: size}
    return effect_values(kind, left, joints)


def payload_in(name: str, values: Mapping[str, Any]) -> Payload:
    """What an effect's values make the arm carry; ``name``: of the mass."""
    said = ((m, values[key]) for key, m in _moments_of(name) if key in values)
    return Payload(values.get(name) or 0.0, tuple((m, at) for m, at in said if at != NULLS[m]))


@cache
def _moments_of(name: str) -> tuple[tuple[str, str], ...]:
    """What the moments of a mass are called among an effect's values, and the moments."""
    return tuple((f"{name}_{m.name}", m.name) for m in LASTING)


def lateness(effects: Mapping[str, Values]) -> float:
    """Age [s] of the joints' readings at their stamps."""
    return float(sum(np.max(age) for age in _first_of(effects, "delays_readings")))


def zeros_in(effects: Mapping[str, Values]) -> Any:
    """(joints,) rad, or one for all: constants in the joints' readings."""
    return sum(_first_of(effects, "shifts_readings"), start=0.0)


def _first_of(effects: Mapping[str, Values], says: str) -> list[Any]:
    """First values of the effects that say that of themselves."""
    those = [(effect(name).parameters[0], v) for name, v in effects.items() if getattr(effect(name), says)]
    return [values.get(lead.name, lead.null) for lead, values in those]
