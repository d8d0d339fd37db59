"""Arms, motions and models that the tests of effects share."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.arm import Arm, Wire
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import Effect, registry
from trunk_ros.effects.bank import Bank
from trunk_ros.model import Model
from trunk_ros.parameter import Parameter

CASES = [(name, form) for name, kind in registry().items() for form in kind.forms]
WIRE = [(name, form) for name, form in CASES if registry()[name].stage == "wire"]
COMPENSABLE = [(name, form) for name, form in WIRE if registry()[name].compensable]


def arm_of(joints: int, dead_band: float = 3e-4) -> Arm:
    """An arm like the nominal one with as many joints as that; its links weigh less the more there are."""
    return Arm(
        joints=tuple(f"joint_{k + 1}" for k in range(joints)),
        ratio=np.full(joints, 0.625),
        dead_band=np.full(joints, dead_band),
        lower=np.full(joints, -0.4),
        upper=np.full(joints, 0.4),
        link_length=np.full(joints, 0.25 / joints),
        link_mass=np.full(joints, 0.25 / joints),
        compliance=np.linspace(0.02, 0.04, joints),
        wire=wire_of(joints),
    )


def wire_of(joints: int) -> Wire:
    """Wires like the nominal ones, as many as that."""
    between = np.linspace(0.06, 0.26, joints)
    return Wire(
        shaft_radius=0.010,
        cylinder_radius=0.016,
        modulus=252523.55e6,
        section=0.113e-6,
        pull_tension=1.0,
        mu1=np.full(joints, 0.10),
        mu2=np.full(joints, 0.08),
        a1=np.full(joints, 0.9774),
        a2=np.full(joints, 0.4189),
        length=between + 0.145,
        length1=np.full(joints, 0.11364),
        length2=between,
    )


def in_plane(tip: Array) -> Array:
    """Poses (n, 7) of a planar arm's tip as y, z [m], roll [rad] (n, 3)."""
    return np.column_stack([tip[:, 1:3], 2.0 * np.arctan2(tip[:, 3], tip[:, 6])])


def motion(stamp: Array, joints: int = 5, amplitude: float = 0.3, pace: float = 1.0) -> Array:
    """Smooth joint angles (n, joints) that start at rest, each joint at a frequency of its own below 0.4
    Hz.
    """
    rates = 2.0 * np.pi * pace * np.linspace(0.13, 0.37, joints)
    part = np.clip(stamp / 4.0, 0.0, 1.0)[:, None]
    rise = part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
    return (
        amplitude * rise * np.sin(stamp[:, None] * rates + np.arange(joints)) / (1 + 0.2 * np.arange(joints))
    )


def alike(got: Array, wanted: Array, within: float) -> None:
    """Assert that signals of one shape differ by no more. pytest.approx goes from number to number, which
    takes as long as to compute them.
    """
    assert np.shape(got) == np.shape(wanted)
    np.testing.assert_allclose(got, wanted, rtol=0.0, atol=within, equal_nan=False)


def stamps(seconds: float, rate: float) -> Array:
    """Even stamps [s] from 0."""
    return np.arange(round(seconds * rate) + 1) / rate


def usual(parameter: Parameter, joint: int) -> float:
    """A usual value of a parameter, a little another for each joint."""
    special = {"onset": 8.0, "low": -0.3, "high": 0.3, "payload": 0.02, "threshold": 0.02, "moment": 0.1}
    special |= {"v_max": 0.3, "excess": 0.85, "upper": 0.18, "lower": -0.18}
    if parameter.name in special:
        return special[parameter.name]
    if parameter.name.startswith("value_"):
        return parameter.typical * float(np.sin(0.3 * int(parameter.name[-2:])))
    if parameter.name.startswith("moment_"):
        return 0.8 * int(parameter.name[-2:]) + 0.003
    return float(np.clip(parameter.typical * (1.0 + 0.05 * joint), *parameter.bounds))


def values_of(name: str, form: str, joints: int) -> dict[str, Any]:
    """What a model holds of an effect of usual size on all joints."""
    kind = registry()[name]
    values: dict[str, Any] = {"form": form} if form else {}
    for p in kind.own_parameters(form):
        own = np.array([usual(p, joint) for joint in range(joints)])
        values[p.name] = float(own[0]) if p.shared else own
    return values | words_of(kind, joints)


def words_of(kind: type[Effect], joints: int) -> dict[str, list[str]]:
    """Sources and variables: each joint's neighbours, or its own position."""
    names = [f"joint_{k + 1}" for k in range(joints)]
    if "on" in kind.texts:
        return {"on": ["position"] * joints}
    if issubclass(kind, Bank) and kind.own:
        own = [kind.choices(tuple(names), name) for name in names]
        return {text: [words[i % len(words)] for words in own] for i, text in enumerate(kind.texts)}
    return {text: [names[k - 1 - i] for k in range(joints)] for i, text in enumerate(kind.texts)}


def model_of(name: str, form: str = "", joints: int = 5, dead_band: float = 3e-4) -> Model:
    """An arm with one effect of usual size."""
    if joints <= 3 and registry()[name].texts and "on" not in registry()[name].texts:
        return Model(arm_of(joints, dead_band), {name: few_sources(name, joints)} if joints > 1 else {})
    return Model(arm_of(joints, dead_band), {name: values_of(name, form, joints)})


def everything(joints: int = 5) -> Model:
    """An arm with every effect of the wire that can be compensated, save those that include another; one
    curve of jumps is enough.
    """
    effects: dict[str, Any] = {}
    for name, form in COMPENSABLE:
        if not registry()[name].replaces and name not in (*effects, "unknown_slips"):
            effects |= model_of(name, form, joints).effects
    return Model(arm_of(joints), effects, duration=16.0)


def few_sources(name: str, joints: int) -> dict[str, Any]:
    """A coupling with one source, for arms that have no more."""
    kind = registry()[name]
    return {
        kind.parameters[0].name: np.full(
            joints, 10.0 * kind.parameters[0].typical if issubclass(kind, Bank) else 0.005
        ),
        kind.texts[0]: words_of(kind, joints)[kind.texts[0]]
        if issubclass(kind, Bank) and kind.own
        else [f"joint_{k or joints}" for k in range(joints)],
    }


def input_of(model: Model, stage: str, theta: Array) -> Array:
    """What a stage takes in for joint angles of about ``theta``."""
    return theta if stage == "arm" else theta / model.arm.ratio


def run(model: Model, stage: str, theta: Array, stamp: Array, **more: Any) -> Array:
    """The stage's output for joint angles of about ``theta``."""
    return Chain(model, stage).run(input_of(model, stage, theta), stamp, **more)[0]
