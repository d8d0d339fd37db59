"""Values of arm effects, as a fit moves them and as a model holds them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from trunk_ros.diagnosis.hypothesis import hypothesis_of
from trunk_ros.effects import Effect, effect, registry
from trunk_ros.model import Values

SHIFT = "shift"  # of a signal by a constant: no effect of the arm, but other frames make one
ZERO = "zero"  # of a joint's reading, off by a constant; that of the first joint is a tilt
NAMELESS = (SHIFT, ZERO)

Key = tuple[str, int]
"""An effect and the joint's column, -1 for the whole arm; SHIFT and the signal's; ZERO and the joint's."""
Point = dict[Key, float]


def point_of(effects: Mapping[str, Values], joints: int) -> Point:
    """The arm effects that a model of so many joints has."""
    out: Point = {}
    for name, term in hypothesis_of(effects, "arm", joints).items():
        lead = effect(name).parameters[0].name
        on = {-1: term.shared} if lead in term.shared else term.own
        out |= {(name, c): values[lead] for c, values in on.items()}
    return out


def credible(key: Key, value: float) -> bool:
    """Whether a value lies within the bounds of its parameter."""
    if key[0] in NAMELESS:
        return True
    low, high = effect(key[0]).parameters[0].bounds
    return low <= value <= high


def bound(values: Point, joints: int) -> list[Effect]:
    """The effects as blocks over so many joints."""
    blocks: list[Effect] = []
    for name in registry():
        mine = {c: v for (n, c), v in values.items() if n == name}
        if mine:
            numbers = np.array([mine.get(c, mine.get(-1, 0.0)) for c in range(joints)])
            blocks.append(effect(name)({effect(name).parameters[0].name: numbers}))
    return blocks


def model_effects(values: Point, joints: int) -> dict[str, Values]:
    """Effects as a model of so many joints holds them."""
    return {
        block.id: {p.name: float(block[p.name][0]) if p.shared else block[p.name] for p in block.parameters}
        for block in bound(values, joints)
    }
