"""The pair of wires with spread friction: its limits in closed form, and beside the finite elements."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.concealed.wire_fe import Pair, joint_angle, pair_of
from trunk_ros.arm import Arm, Wire
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.wire.distributed_wire import DistributedWire, pieces_of
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model

ARM: Arm = load_model("trunk").arm
THERE_AND_BACK = np.concatenate([np.linspace(0, 0.02, 300), np.linspace(0.02, -0.02, 600)])
PRETENSION = 8.0  # N


def wire() -> Wire:
    """The nominal wire."""
    assert ARM.wire is not None
    return ARM.wire


def pair(u: Array, load: Array, **values: float) -> Array:
    """Joint angles (n, joints) of the pair alone, for (n,) rad before it and (n,) N m."""
    numbers = {"pretension": PRETENSION, "friction": 1.0} | values
    effect = DistributedWire({name: np.full(5, value) for name, value in numbers.items()})
    spread = np.tile(load[:, None], (1, 5))
    stamp = np.arange(float(len(u)))
    seen = dict.fromkeys(("gearbox", "speed", "load", "angles", "wires"), spread)
    now = Now(stamp=stamp, dt=stamp, joints=ARM.joints, ratio=ARM.ratio, **seen)
    core = Core(nominal_width=ARM.dead_band[None], width=ARM.dead_band[None], wire=wire())
    effect.adjust(core, now)
    out: Array = core.rounding.run(np.tile(u[:, None], (1, 5)), core.width, None)[0]
    return out


def full_slip() -> tuple[Array, Array]:
    """Half-width [rad] and compliance [rad/(N m)] of the docstring's formulas, (joints,)."""
    soft, grip = pieces_of(wire(), np.ones(5))
    to_joint = np.column_stack([grip[:, ::-1].cumsum(axis=1)[:, ::-1], np.zeros(5)])
    more, less = ((soft * np.exp(sign * to_joint)).sum(axis=1) for sign in (1.0, -1.0))
    radius = wire().cylinder_radius
    width = PRETENSION * soft.sum(axis=1) * (more - less) / (more + less) / radius
    return width, more * less / (more + less) / radius**2


def elements(joint: int) -> Pair:
    """The same wire as finite elements: there the arcs come on top of l' and l''."""
    arcs = wire().shaft_radius * wire().a1[joint], wire().shaft_radius * wire().a2[joint]
    straight = float(wire().length1[joint] - arcs[0]), float(wire().length2[joint] - arcs[1])
    return replace(pair_of(joint, PRETENSION), straight=straight)


def test_the_stretches_make_up_the_whole_wire() -> None:
    soft, grip = pieces_of(wire(), np.ones(5))
    assert soft.sum(axis=1) == pytest.approx(wire().length / (wire().modulus * wire().section))
    assert np.exp(-grip.sum(axis=1)) == pytest.approx(wire().efficiency)


def test_without_load_it_is_a_sharp_play_of_the_formulas_width() -> None:
    width, _ = full_slip()
    got = pair(THERE_AND_BACK, np.zeros(len(THERE_AND_BACK)))
    theta = np.zeros(5)
    for k, u in enumerate(THERE_AND_BACK):
        theta = np.clip(theta, u - width, u + width)
        if k > 100:
            assert got[k] == pytest.approx(theta, abs=1e-7)


def test_in_motion_a_load_deflects_the_joint_by_the_formula() -> None:
    _, compliance = full_slip()
    load = np.full(len(THERE_AND_BACK), 0.02)
    sag = pair(THERE_AND_BACK, load) - pair(THERE_AND_BACK, 0 * load)
    assert sag[299] == pytest.approx(0.02 * compliance, rel=1e-3)
    assert sag[-1] == pytest.approx(0.02 * compliance, rel=1e-3)


def test_at_rest_friction_carries_a_small_load_in_part() -> None:
    _, compliance = full_slip()
    sag = pair(np.zeros(50), np.linspace(0, 0.01, 50))[-1]
    assert np.all((sag > 0.0) & (sag < 0.6 * 0.01 * compliance))


def test_past_some_load_one_wire_is_slack_and_the_joint_twice_as_soft() -> None:
    load = np.linspace(0, 1.0, 400)
    sag = pair(np.zeros(400), load)
    slope = np.gradient(sag, load, axis=0)
    assert slope[-5] / slope[80] == pytest.approx(2.0, rel=0.15)


def test_more_friction_and_more_pretension_widen_the_dead_band() -> None:
    still = np.zeros(len(THERE_AND_BACK))
    once, twice, rough = (
        THERE_AND_BACK[299] - pair(THERE_AND_BACK, still, **more)[299]
        for more in ({}, {"pretension": 2 * PRETENSION}, {"friction": 2.0})
    )
    assert twice == pytest.approx(2 * once, rel=1e-6)
    assert rough == pytest.approx(2 * once, rel=0.02)


SWING = np.sin(np.arange(900) * 0.01)


@pytest.mark.parametrize("joint", [0, 4])
@pytest.mark.parametrize(
    ("u", "load"),
    [
        pytest.param(THERE_AND_BACK, 0.0 * SWING, id="unloaded"),
        pytest.param(0.0 * SWING, 0.06 * SWING, id="load at rest"),
        pytest.param(THERE_AND_BACK, 0.04 * SWING, id="both"),
        pytest.param(6e-4 * np.sin(np.arange(900) * 0.021), 0.03 * SWING, id="within the dead band"),
    ],
)
def test_it_is_what_finite_elements_with_stick_and_slip_give(joint: int, u: Array, load: Array) -> None:
    expected = joint_angle(elements(joint), u / 0.625, load)
    assert pair(u, load)[:, joint] == pytest.approx(expected, abs=3e-6)


def test_a_model_without_the_wires_formula_cannot_have_it() -> None:
    bare: dict[str, Any] = {"distributed_wire": {"pretension": np.full(2, 5.0)}}
    chain = Chain(Model(load_model("direct").for_joints(("a", "b")).arm, bare), "wire")
    with pytest.raises(ModelError, match="wants the wire's formula"):
        chain.run(np.zeros((1, 2)), np.zeros(1))


def test_backlash_adds_to_it() -> None:
    stamp = np.arange(len(THERE_AND_BACK)) * 0.01
    phi = np.tile(THERE_AND_BACK[:, None], (1, 5)) / 0.625
    alone: dict[str, Any] = {"distributed_wire": {"pretension": np.full(5, PRETENSION)}}
    more = alone | {"backlash": {"half_width": np.full(5, 1e-3)}}
    weightless = replace(ARM, link_mass=np.zeros(5))
    got = [Chain(Model(weightless, effects), "wire").run(phi, stamp)[0][299] for effects in (alone, more)]
    assert got[0] - got[1] == pytest.approx(1e-3, abs=1e-6)
