"""Values of arm effects, as a fit moves them and as a model holds them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.effect_values import Values
from trunk_ros.effects import Effect, effect, registry
from trunk_ros.parameter import Parameter

SHIFT = "shift"  # of a signal by a constant: no effect of the arm, but other frames make one
ZERO = "zero"  # of a joint's reading, off by a constant; that of the first joint is a tilt
NAMELESS = (SHIFT, ZERO)

Key = tuple[str, int]
"""A value and the joint's column, -1 for the whole arm. The value is an effect's first parameter, by the
effect's ID, or EFFECT.PARAMETER; SHIFT and the signal's column; ZERO and the joint's."""
Point = dict[Key, float]


def value_name(kind: type[Effect], parameter: Parameter) -> str:
    """What a parameter of an effect is called in a Key."""
    return kind.id if parameter is kind.parameters[0] else f"{kind.id}.{parameter.name}"


def owner(key: Key) -> str:
    """The effect of a value."""
    return key[0].partition(".")[0]


def parameter_of(key: Key) -> Parameter:
    """The parameter that a value is of."""
    name, _, parameter = key[0].partition(".")
    return effect(name).parameter(parameter) if parameter else effect(name).parameters[0]


def candidates(arm: Arm, signals: int) -> list[Key]:
    """What an arm can have: of a chain in a plane what moves its tip there, and what of that has no name."""
    joints, named = range(len(arm.joints)), list[Key]()
    for kind in registry().values():
        tried = kind.stage == "arm" and kind.tried and (not arm.is_planar or kind.in_plane)
        if tried and ("weight" not in kind.needs or arm.has_load):
            for p in kind.parameters[: 1 if arm.is_planar else None]:
                named += [(value_name(kind, p), c) for c in ([-1] if p.shared else joints)]
    if not arm.is_planar:
        return named
    return [*named, *((SHIFT, k) for k in range(signals)), *((ZERO, c) for c in joints[1:])]


def of_sensors() -> list[str]:
    """Effects of other stages by which a joint's reading is off by a constant."""
    return [kind.id for kind in registry().values() if kind.shifts_readings]


def told_otherwise(arm: Arm) -> set[Key]:
    """Values that are not chosen, as frames say the same: the last link is the tool's place."""
    if arm.is_planar:
        return set()
    last = arm.body.own.index(max(arm.body.own, key=arm.body.path.index))
    return {k for k in candidates(arm, 0) if k[1] == last and effect(owner(k)).shifts_links}


def point_of(effects: Mapping[str, Values], joints: int) -> Point:
    """The arm effects that a model of so many joints has."""
    out: Point = {}
    for name, values in effects.items():
        for parameter in effect(name).parameters if effect(name).stage == "arm" else ():
            key, value = value_name(effect(name), parameter), values.get(parameter.name, parameter.null)
            if parameter.shared:
                out |= {(key, -1): float(value)} if value != parameter.null else {}
            else:
                own = np.broadcast_to(value, (joints,))
                out |= {(key, c): float(v) for c, v in enumerate(own) if v != parameter.null}
    return out


def credible(key: Key, value: float) -> bool:
    """Whether a value lies within the bounds of its parameter."""
    if key[0] in NAMELESS:
        return True
    low, high = parameter_of(key).bounds
    return low <= value <= high


def bound(values: Point, joints: int) -> list[Effect]:
    """The effects as blocks over so many joints."""
    blocks: list[Effect] = []
    mentioned = {owner(key) for key in values}
    for name, kind in registry().items():
        if name in mentioned:
            numbers = {p.name: _column(values, value_name(kind, p), joints) for p in kind.parameters}
            blocks.append(kind(numbers))
    return blocks


def _column(values: Point, name: str, joints: int) -> Array:
    shared = values.get((name, -1), 0.0)
    return np.array([values.get((name, c), shared) for c in range(joints)])


def model_effects(values: Point, joints: int) -> dict[str, Values]:
    """Effects as a model of so many joints holds them."""
    mentioned = {key[0] for key in values}
    return {
        block.id: {
            p.name: float(block[p.name][0]) if p.shared else block[p.name]
            for p in block.parameters
            if value_name(type(block), p) in mentioned or p is block.parameters[0]
        }
        for block in bound(values, joints)
    }
