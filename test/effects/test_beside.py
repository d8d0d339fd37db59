"""Effects on different joints do not touch each other: each joint does what it does with its own alone."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from test.effects.example import WIRE, alike, arm_of, motion, run, stamps, values_of
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import registry
from trunk_ros.model import Model

JOINTS = 3
STAMP = stamps(10, 100)
THETA = motion(STAMP, JOINTS)
ALONE = [
    (name, form)
    for name, form in WIRE
    if not registry()[name].texts and not registry()[name].everywhere
    if "load" not in registry()[name].needs and form not in registry()[name].shaking
    if not any(p.shared for p in registry()[name].own_parameters(form))
]
"""Effects that a joint has for itself, whatever the others do."""


def on_joint(name: str, form: str, joint: int) -> dict[str, Any]:
    """An effect of usual size on one joint, absent on the others."""
    kind = registry()[name]
    values, there = values_of(name, form, JOINTS), np.arange(JOINTS) == joint
    own = {p.name: np.where(there, values[p.name], p.null) for p in kind.own_parameters(form)}
    return {name: {**values, **own}}


def shown(effects: dict[str, Any]) -> Array:
    return run(Model(arm_of(JOINTS), effects), "wire", THETA, STAMP)


@cache
def alone(name: str, form: str, joint: int) -> Array:
    return np.asarray(shown(on_joint(name, form, joint))[:, joint])


@pytest.mark.parametrize(("name", "form"), ALONE)
def test_each_joint_does_what_its_own_effect_says(name: str, form: str) -> None:
    for other, its_form in ALONE:
        if other != name:
            both = shown(on_joint(name, form, 0) | on_joint(other, its_form, 2))
            alike(both[:, 0], alone(name, form, 0), 1e-9)
            alike(both[:, 2], alone(other, its_form, 2), 1e-9)


def test_each_joint_is_compensated_as_its_own_effect_wants() -> None:
    rounded, held = ("presliding_hysteresis", "compliant", 0), ("link_resonance", "held", 2)
    each = [on_joint(*rounded), on_joint(*held), on_joint(*rounded) | on_joint(*held)]
    one, other, both = (
        Chain(Model(arm_of(JOINTS), effects), "wire").invert(THETA, STAMP)[0] for effects in each
    )
    alike(both[:, 0], one[:, 0], 1e-9)
    alike(both[:, 2], other[:, 2], 1e-9)
