"""Geometry, weight, and the paper's dead bands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from test.effects.example import arm_of, in_plane
from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError
from trunk_ros.model import load_model

# Elongations [um] with Table 1 as printed and A_s = 0.113 mm^2. Eq. (7) has a factor 1/k_i that (6) has not.
EQUATION_6 = (5.8576, 7.4514, 9.0405, 10.6295, 12.2186)
EQUATION_7 = (5.0871, 6.5348, 7.9284, 9.3221, 10.7157)
postures = arrays(float, 5, elements=st.floats(-3.0, 3.0))


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_model("trunk").arm


def test_elongations_are_those_of_the_formula_and_table_1(arm: Arm) -> None:
    assert arm.wire is not None
    assert arm.wire.elongation * 1e6 == pytest.approx(EQUATION_6, abs=6e-5)
    assert arm.wire.elongation * arm.wire.efficiency * 1e6 == pytest.approx(EQUATION_7, abs=6e-5)


def test_dead_bands_are_the_elongations_over_the_joints_radius(arm: Arm) -> None:
    assert arm.dead_band == pytest.approx(np.array(EQUATION_6) * 1e-6 / 0.016, rel=1e-5)


def test_the_ratio_is_that_of_the_radii(arm: Arm) -> None:
    assert arm.ratio.tolist() == [0.625] * 5


def test_efficiencies_are_the_papers_with_the_printed_friction(arm: Arm) -> None:
    assert arm.wire is not None
    assert arm.wire.efficiency[:2] == pytest.approx([0.8685, 0.8770], abs=1e-4)


def test_the_wires_compliance_is_l_over_e_a_r_squared(arm: Arm) -> None:
    expected = np.array([0.204, 0.254, 0.304, 0.354, 0.404]) / (252523.55e6 * 0.113e-6 * 0.016**2)
    assert arm.compliance == pytest.approx(expected)


@given(theta=postures)
def test_the_tip_is_the_end_of_the_planar_chain(theta: Array) -> None:
    y = z = heading = 0.0
    for angle in theta:
        heading += angle
        y -= 0.05 * np.sin(heading)
        z += 0.05 * np.cos(heading)
    *place, roll = in_plane(load_model("trunk").arm.tip(theta[None]))[0]
    wanted = [y, z, np.cos(heading), np.sin(heading)]
    assert [*place, np.cos(roll), np.sin(roll)] == pytest.approx(wanted, abs=1e-12)


def potential(arm: Arm, theta: Array) -> float:
    """Energy [J] of all masses above the base."""
    heading = np.cumsum(theta)
    height = np.concatenate([[0.0], np.cumsum(arm.link_length * np.cos(heading))])
    middles = (height[1:] + height[:-1]) / 2
    return float(arm.gravity * (middles @ arm.link_mass + arm.payload * height[-1]))


@given(theta=postures, payload=st.floats(0.0, 0.5))
def test_the_load_is_what_the_weight_loses_in_height(theta: Array, payload: float) -> None:
    """Virtual work: tau_i = -dE/dtheta_i, positive where it tends to increase the angle."""
    nominal = load_model("trunk").arm
    arm = Arm(**{**vars_of(nominal), "payload": payload})
    step = 1e-5
    for joint, moment in enumerate(arm.load(theta[None])[0]):
        lift = np.eye(5)[joint] * step
        work = potential(arm, theta + lift) - potential(arm, theta - lift)
        assert moment == pytest.approx(-work / (2 * step), abs=1e-7)


def vars_of(arm: Arm) -> dict[str, object]:
    """The fields of an arm."""
    return {name: getattr(arm, name) for name in Arm.__dataclass_fields__}


@given(theta=postures)
def test_a_payload_pulls_with_its_lever(theta: Array) -> None:
    bare, loaded = arm_of(5), Arm(**{**vars_of(arm_of(5)), "payload": 0.3})
    difference = loaded.load(theta[None]) - bare.load(theta[None])
    assert difference == pytest.approx(0.3 * bare.lever(theta[None]), abs=1e-12)


def test_an_upright_arm_carries_nothing() -> None:
    assert arm_of(5).load(np.zeros((1, 5))) == pytest.approx(0.0, abs=1e-15)


def test_an_arm_without_masses_has_no_load() -> None:
    arm = load_model("direct").for_joints(("a", "b")).arm
    assert arm.load(np.ones((3, 2))).tolist() == [[0.0, 0.0]] * 3
    assert not arm.has_geometry


def test_some_of_the_joints_make_an_arm_without_geometry(arm: Arm) -> None:
    part = arm.only(("joint_4", "joint_2"))
    assert part.joints == ("joint_4", "joint_2")
    assert part.dead_band.tolist() == [arm.dead_band[3], arm.dead_band[1]]
    assert not part.has_geometry


def test_an_unknown_joint_is_named_with_those_that_exist(arm: Arm) -> None:
    with pytest.raises(ModelError, match=r"unknown joint 'elbow': the model has joint_1, .*joint_5"):
        arm.index("elbow")


def test_values_that_do_not_match_the_joints_are_refused() -> None:
    with pytest.raises(ModelError, match="ratio has 3 values for 5 joints"):
        Arm(**{**vars_of(arm_of(5)), "ratio": np.ones(3)})


def test_a_slow_motor_limits_the_joints_that_it_moves_and_no_others() -> None:
    coupling = np.array([[1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 2.0]])
    arm = replace(
        load_model("direct").for_joints(("a", "b", "c")).arm,
        coupling=coupling,
        v_max=np.array([9.0, 0.3, 4.0]),
    )
    np.testing.assert_allclose(arm.top_speed, [0.2, 0.2, 8.0])
    motors = np.abs(np.linalg.inv(coupling)) @ arm.top_speed
    assert (motors <= np.asarray(arm.v_max) + 1e-12).all()
