"""A plant is the model itself, tick by tick, for one arm and for many at once."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.effects.example import motion, stamps
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError
from trunk_ros.export.missing import missing
from trunk_ros.export.reality.layer import RealityLayer
from trunk_ros.model import Model, load_model

RATE = 100.0
STAMP = stamps(12.0, RATE)
ARM = load_model("trunk").arm
EFFECTS = {
    "backlash": {"half_width": np.array([2e-3, 0.0, 4e-3, 0.0, 0.0])},
    "joint_coupling": {"gain": np.array([0.0, 0.0, 0.0, 0.02, 0.0]), "source": ["", "", "", "joint_2", ""]},
    "sensor_delay": {"delay": 0.02},
    "servo_bandwidth": {"relative": -0.2},
}
MODEL = Model(ARM, EFFECTS)


def setpoints(environments: int) -> Array:
    """(n, environments, joints) at rest at first: each environment moves at another pace."""
    paces = np.linspace(1.0, 0.5, environments)
    still = np.clip(STAMP, 0.0, 1.0)[:, None]
    return np.stack([still * motion(STAMP, 5, 0.2, pace) / 0.625 for pace in paces], axis=1)


def readings(model: Model, environments: int) -> Array:
    """(n, environments, joints) after each step."""
    plant = model.plant(environments)
    plant.reset()
    return np.array([plant.step(row, 1.0 / RATE) for row in setpoints(environments)])


@pytest.mark.parametrize("effects", [{}, EFFECTS], ids=["nominal", "with effects"])
def test_it_reads_what_simulate_does(effects: dict) -> None:
    model, given = Model(ARM, effects), setpoints(1)[:, 0]
    phi = Chain(model, "servo").run(given, STAMP)[0]
    expected = Chain(model, "wire").run(phi, STAMP)[0]
    off = readings(model, 1)[:-1, 0] - expected[1:]
    assert np.abs(off[20:]).max() < 2e-4
    assert np.ptp(expected, axis=0).min() > 0.1


def test_many_arms_are_as_each_by_itself() -> None:
    together, given = readings(MODEL, 3), setpoints(3)
    alone = MODEL.plant()
    alone.reset()
    np.testing.assert_allclose(
        together[:, 2], [alone.step(row, 1.0 / RATE) for row in given[:, 2]], atol=1e-9
    )


def test_those_that_are_reset_begin_anew_and_the_others_go_on() -> None:
    given = setpoints(2)
    plant, other = MODEL.plant(2), MODEL.plant(2)
    plant.reset(), other.reset()
    for row in given[:500]:
        plant.step(row, 1.0 / RATE), other.step(row, 1.0 / RATE)
    shown = plant.reset(np.array([True, False]), posture=0.1)
    np.testing.assert_allclose(shown[0], 0.1)
    held = np.where(np.array([True, False])[:, None], 0.1 / ARM.ratio, given[500])
    after, gone_on = plant.step(held, 1.0 / RATE), other.step(given[500], 1.0 / RATE)
    np.testing.assert_allclose(after[0], 0.1, atol=5e-3)
    np.testing.assert_array_equal(after[1], gone_on[1])


def test_what_cannot_be_is_refused_in_one_line() -> None:
    with pytest.raises(ModelError, match="a model with joints"):
        load_model("direct").plant()
    with pytest.raises(ModelError, match="give 1 or more"):
        MODEL.plant(0)
    with pytest.raises(ModelError, match="2 environments of joint_1"):
        MODEL.plant(2).step(np.zeros(5), 0.01)


@pytest.mark.parametrize(
    "servo",
    [
        {"tau_v": 2e-4},
        {"kp": 400.0, "tau_v": 1e-3},
        {"delay": 0.03},
        {"feedforward": 0.7, "delay": 0.01},
        {"kp": np.array([8.0, 20.0, 20.0, 20.0, 60.0]), "delay": np.array([0.0, 0.05, 0.0, 0.0, 0.01])},
    ],
    ids=["quick", "stiff", "late", "fed", "apart"],
)
def test_servos_of_any_numbers_go_as_simulate_has_them(servo: dict[str, Any]) -> None:
    model = Model(replace(ARM, **servo))
    phi = Chain(model, "servo").run(setpoints(1)[:, 0], STAMP)[0]
    expected = Chain(model, "wire").run(phi, STAMP)[0]
    off = readings(model, 1)[:-1, 0] - expected[1:]
    assert np.abs(off[20:]).max() < 1e-3


@pytest.mark.parametrize(
    ("told", "effects"),
    [
        ({}, {"velocity_saturation": {"v_max": 0.5}}),
        ({}, {"velocity_saturation": {"v_max": 3.0}}),
        ({}, {"uneven_speed": {"excess": np.full(5, 0.2)}}),
        ({}, {"velocity_saturation": {"v_max": 2.0}, "uneven_speed": {"excess": np.full(5, -0.2)}}),
        ({}, {"velocity_loop": {"relative": 1.0}, "servo_bandwidth": {"relative": -0.2}}),
        ({"delay": 0.02}, {"servo_delay": {"delay": -0.01}}),
        ({}, {"setpoint_ceiling": {"upper": 0.3}}),
        ({}, {"acceleration_limit": {"acceleration": 6.0}}),
        ({}, {"motor_friction": {"friction": 0.01}}),
        ({}, {"integral_action": {"ki": np.array([0.0, 5.0, 15.0, 15.0, 60.0])}}),
        ({}, {"speed_integral": {"rate": 8.0}}),
    ],
    ids=[
        "slower",
        "faster",
        "uneven",
        "uneven and faster",
        "other loops",
        "less late",
        "clipped",
        "current-limited",
        "dry",
        "summing up",
        "summing up its speed",
    ],
)
def test_servos_at_their_top_speed_go_as_simulate_has_them(
    told: dict[str, Any], effects: dict[str, Any]
) -> None:
    shown, expected = of_steps(Model(replace(ARM, **told), effects))
    np.testing.assert_allclose(shown, expected, atol=1e-9)


def test_servos_that_go_along_profiles_do_so_in_the_mean_of_each_step() -> None:
    profiles = {"setpoint_profile": {"acceleration": np.array([1.0, 2.0, 4.0, 8.0, 1e6])}}
    shown, expected = of_steps(Model(ARM, profiles | {"velocity_saturation": {"v_max": 0.8}}))
    np.testing.assert_allclose(shown, expected, atol=1e-4)


@pytest.mark.parametrize("fed", [0.0, 0.8])
def test_a_profile_begins_where_the_arm_stands(fed: float) -> None:
    """Also of those that are reset while others go on."""
    model = Model(replace(ARM, feedforward=fed), {"setpoint_profile": {"acceleration": 2.0}})
    asked, stands = np.full((200, 5), 0.5), np.array([-0.3, 0.0, 0.1, 0.4, 0.0])
    plant = model.plant(2)
    plant.reset(posture=stands * ARM.ratio)
    motors = np.array([(plant.step([row, row], 1.0 / RATE), plant.motors)[1] for row in asked])
    plant.reset(np.array([False, True]), stands * ARM.ratio)
    again = np.array([(plant.step([row, row], 1.0 / RATE), plant.motors[1])[1] for row in asked])
    phi = Chain(model, "servo").run(np.vstack([stands, asked, asked[:1]]), STAMP[:202])[0]
    np.testing.assert_allclose(motors[:, 0], phi[2:], atol=1e-3)
    np.testing.assert_allclose(again, motors[:, 1], atol=1e-9)


@pytest.mark.parametrize("beside", [{"uneven_speed": {"excess": 0.3}}, {"speed_feedforward": {"share": 0.6}}])
def test_commands_to_a_simulator_go_along_the_profile_and_no_slower(beside: dict[str, Any]) -> None:
    profile = {"setpoint_profile": {"acceleration": 3.0}, "velocity_saturation": {"v_max": 0.5}}
    model, asked = Model(ARM, profile | beside), setpoints(1)[:, 0] + 0.4 * (STAMP > 3.0)[:, None]
    layer = RealityLayer(model)
    sent = np.array([layer.step(row, 0.0 * row, 1.0 / RATE)[0] for row in asked])
    simulator = Chain(Model(replace(ARM, v_max=50.0)), "servo")
    there = simulator.run(sent, STAMP)[0] - Chain(model, "servo").run(asked, STAMP)[0]
    assert np.abs(there).max() < 2e-3


def of_steps(model: Model) -> tuple[Array, Array]:
    """What a plant shows of steps of its setpoints, and what should be (n - 1, joints)."""
    stands = STAMP < 1.0
    asked = np.where(stands, 0.0, np.where(np.floor(STAMP / 0.7) % 2 == 0.0, 0.6, -0.6))
    asked = np.tile(asked[:, None], (1, 5))
    phi = Chain(model, "servo").run(asked, STAMP)[0]
    plant = model.plant()
    plant.reset()
    shown = np.array([plant.step(row, 1.0 / RATE) for row in asked])
    return shown[:-1], Chain(model, "wire").run(phi, STAMP)[0][1:]


@pytest.mark.parametrize("step", [1e-3, 0.0])
def test_loops_that_run_faster_are_as_simulate_has_them(step: float) -> None:
    model = Model(replace(ARM, step=step))
    phi = Chain(model, "servo").run(setpoints(1)[:, 0], STAMP)[0]
    np.testing.assert_allclose(
        readings(model, 1)[:-1, 0], Chain(model, "wire").run(phi, STAMP)[0][1:], atol=1e-9
    )


def test_what_a_simulator_has_of_each_joint_is_taken_from_what_all_of_the_arm_share() -> None:
    each = np.array([0.1, 0.0, -0.2, 0.0, 0.0])
    theirs = Model(ARM, {"servo_bandwidth": {"relative": each, "form": "apart"}})
    arm = Model(ARM, {"servo_bandwidth": {"relative": 0.3}})
    added = missing(arm, theirs).model
    np.testing.assert_allclose(added.number("kp"), arm.number("kp") * np.ones(5))
    back = missing(theirs, arm).model
    np.testing.assert_allclose(back.number("kp"), theirs.number("kp"))


def test_an_integral_part_brings_back_what_a_load_pulls_away() -> None:
    """And does not sum up what it is fed."""
    droop, ki = {"gain": 0.02, "form": "weight"}, {"ki": 60.0}
    model = Model(replace(ARM, feedforward=0.6), {"load_droop": droop, "integral_action": ki})
    asked = np.tile(np.minimum(0.2 * STAMP, 0.5)[:, None], (1, 5))
    plant = model.plant()
    plant.reset()
    plant.step(asked[0], 1.0 / RATE)
    motors = np.array([(plant.step(row, 1.0 / RATE), plant.motors[0])[1] for row in asked[1:]])
    phi = Chain(model, "servo").run(asked, STAMP)[0]
    np.testing.assert_allclose(motors[:-1], phi[2:], atol=3e-4)
    assert np.abs(phi - asked).max() > 3e-3
    np.testing.assert_allclose(motors[-1], asked[-1], atol=1e-5)
