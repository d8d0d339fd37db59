"""The reality layer around a simulator that follows its commands is the model itself."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from test.effects.example import WIRE, everything, model_of, motion, stamps
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import effect
from trunk_ros.effects.curve import VALUES
from trunk_ros.errors import ModelError
from trunk_ros.export.missing import missing
from trunk_ros.export.reality import RealityLayer
from trunk_ros.model import Model, load_model

RATE = 100.0
STAMP = stamps(10.0, RATE)
HELD = [(name, form) for name, form in WIRE if name != "distributed_wire"]


def around_ideal(layer: RealityLayer, commands: Array, lag: float = 0.0) -> tuple[Array, Array]:
    """Joint angles after each step and what is shown (n, environments, joints), around a simulator that is
    ``lag`` s behind its commands.
    """
    ratio = layer.model.arm.ratio
    state = commands[0] * ratio
    left = np.exp(-1.0 / RATE / lag) if lag else 0.0
    true, shown = [], []
    for command in commands:
        sent, seen = layer.step(command, state, 1.0 / RATE)
        shown.append(seen)
        state = left * state + (1.0 - left) * sent * ratio
        true.append(state)
    return np.array(true), np.array(shown)


def commands_of(environments: int, joints: int = 5) -> Array:
    """(n, environments, joints): each environment moves at another pace."""
    paces = np.linspace(1.0, 0.6, environments)
    return np.stack([motion(STAMP, joints, 0.25, pace) / 0.625 for pace in paces], axis=1)


@cache
def one(name: str, form: str) -> tuple[Array, Array]:
    """An effect in one environment, as from ``around_ideal``."""
    return around_ideal(RealityLayer(model_of(name, form)), commands_of(1))


def errors(model: Model, shown: Array) -> tuple[float, float]:
    """Largest error of what a layer has shown (n, environments, joints) against the chain, and how much the
    model does, rad.
    """
    off, size, commands = 0.0, 0.0, commands_of(shown.shape[1])
    for k in range(shown.shape[1]):
        chain = Chain(model, "wire", hold_time=True)
        reading = chain.run(commands[:, k], STAMP)[0]
        off = max(off, float(np.abs(shown[1:, k] - reading[:-1])[20:].max()))
        size = max(size, float(np.abs(reading - commands[:, k] * model.arm.ratio).max()))
    return off, size


@pytest.mark.parametrize(("name", "form"), HELD)
def test_every_effect_of_the_wire_comes_out_as_in_simulate(name: str, form: str) -> None:
    """Other joints are seen a step late, so that it is not the same to the last digit."""
    off, size = errors(model_of(name, form), one(name, form)[1])
    assert off < max(0.02 * size, 1e-6)


@pytest.mark.parametrize(("name", "form"), HELD)
def test_many_environments_are_as_many_layers(name: str, form: str) -> None:
    commands, model = commands_of(3)[:300], model_of(name, form)
    together = around_ideal(RealityLayer(model, 3), commands)
    last = around_ideal(RealityLayer(model), commands[:, 2])
    for a, b, c in zip(together, one(name, form), last, strict=True):
        np.testing.assert_allclose(a[:, :1], b[:300], atol=1e-12)
        np.testing.assert_allclose(a[:, 2], c, atol=1e-12)


@pytest.mark.parametrize("name", ["wire_slip", "wire_stiffening", "viscous_lag", "sensor_delay"])
def test_what_has_another_size_in_the_end_has_it_here(name: str) -> None:
    model = model_of(name, effect(name).forms[0])
    shared = effect(name).moments()[0].shared
    again = {key: v if shared else np.full(5, v) for key, v in (("from_2", 8.0), ("times_2", 1.8))}
    model = replace(model, effects={name: {**model.effects[name], **again}}, duration=10.0)
    off, size = errors(model, around_ideal(RealityLayer(model, 2), commands_of(2))[1])
    assert off < max(0.02 * size, 1e-6)


def test_all_effects_at_once() -> None:
    off, size = errors(everything(), around_ideal(RealityLayer(everything(), 2), commands_of(2))[1])
    assert off < 0.03 * size


def test_environments_begin_anew_one_by_one() -> None:
    model, commands = everything(), commands_of(2)
    layer = RealityLayer(model, 2)
    around_ideal(layer, commands[:900])
    layer.reset([False, True])
    fresh = RealityLayer(model)
    ratio = layer.model.arm.ratio
    state, alone = commands[0] * ratio, commands[0, 1] * ratio
    for command in commands[:300]:
        (sent, seen), (own, shown) = (
            layer.step(command, state, 1 / RATE),
            fresh.step(command[1], alone, 1 / RATE),
        )
        np.testing.assert_allclose(sent[1], own, atol=1e-12)
        np.testing.assert_allclose(seen[1], shown, atol=1e-12)
        state, alone = sent * ratio, own * ratio


def test_a_simulator_that_lags_still_moves_as_the_arm() -> None:
    """Motors that lag and then a dead band: the layer has both in this order before the simulator's lag."""
    model, commands, lag = model_of("backlash", "", dead_band=4e-3), commands_of(1)[:, 0], 0.05
    left, motor = np.exp(-1.0 / RATE / lag), np.empty_like(commands)
    before = commands[0]
    for k, command in enumerate(commands):
        motor[k] = before = left * before + (1.0 - left) * command
    arm = Chain(model, "wire").run(motor, STAMP)[0]
    true, _ = around_ideal(RealityLayer(model, lag=lag), commands, lag)
    naive, _ = around_ideal(RealityLayer(model), commands, lag)
    assert np.abs(true - arm)[20:].max() < 1e-5
    assert np.abs(naive - arm)[20:].max() > 1e-4


def test_servo_effects_come_before_the_simulators_own_loop() -> None:
    arm = load_model("trunk").arm
    bare = Model(arm)
    late = Model(arm, {"servo_delay": {"delay": 0.05}, "servo_bandwidth": {"relative": -0.4}})
    commands = commands_of(1)[:, 0]
    sent = np.array(_sent(late, bare, commands))
    own = Chain(bare, "servo").run(sent, STAMP)[0]
    wanted = Chain(late, "servo").run(commands, STAMP)[0]
    nominal = Chain(bare, "servo").run(commands, STAMP)[0]
    assert np.abs(own - wanted)[40:].max() < 0.05 * np.abs(nominal - wanted).max()


def test_a_servo_that_is_faster_one_way_is_asked_as_fast_as_it_goes_each_way() -> None:
    """By the top speed that was found, where one was."""
    arm = load_model("trunk").arm
    uneven = {"uneven_speed": {"excess": np.full(5, 0.2)}}
    asked = np.where(np.floor(STAMP / 2.0) % 2.0 == 0.0, 1.0, -1.0)[:200, None] * np.ones(5)
    asked[0] = 0.0
    for found, top in ({}, arm.v_max), ({"velocity_saturation": {"v_max": 3.0}}, 3.0):
        model = Model(arm, uneven | found)
        back = np.array(_sent(model, Model(arm), np.concatenate([asked, -asked])))
        speed = np.diff(back, axis=0) * RATE
        assert speed.max() == pytest.approx(1.2 * top)
        assert speed.min() == pytest.approx(-0.8 * top)


def test_a_simulator_that_is_later_than_the_arm_is_said_to_be_and_one_that_is_not_gets_the_rest() -> None:
    arm = load_model("trunk").arm
    told = replace(arm, delay=0.02)
    less = Model(told, {"servo_delay": {"delay": -0.015}})
    lacking = missing(less)
    assert "servo_delay" not in lacking.model.effects
    np.testing.assert_allclose(lacking.model.arm.delay, 0.005)
    for late in Model(told), Model(arm, {"servo_delay": {"delay": 0.02}}):
        lacking = missing(less, late)
        np.testing.assert_allclose(lacking.model.arm.delay, 0.0, atol=1e-12)
        assert [remark for remark in lacking.remarks if "0.015 s" in remark]
    lacking = missing(less, Model(replace(arm, delay=0.002)))
    np.testing.assert_allclose(lacking.model.arm.delay, 0.003)
    assert not lacking.remarks


def _sent(model: Model, simulation: Model, commands: Array) -> list[Array]:
    layer = RealityLayer(model, simulation=simulation)
    return [layer.step(command, command * model.arm.ratio, 1 / RATE)[0] for command in commands]


def test_friction_on_some_motors_leaves_the_others_alone() -> None:
    """Also where no wire has a play of its own."""
    bare = load_model("trunk")
    arm = replace(bare.arm, dead_band=np.zeros(5))
    friction = np.array([0.5, 0.0, 0.0, 0.0, 0.5])
    droop = {"form": "weight_and_friction", "gain": 1e-3, "friction": friction}
    commands = commands_of(1)[:400, 0]
    sent, plain = (
        around_ideal(RealityLayer(Model(arm, effects)), commands)[0]
        for effects in ({"load_droop": droop}, {"load_droop": {**droop, "friction": 0.0 * friction}})
    )
    off = np.abs(sent - plain).max(axis=0)
    assert (off[friction > 0.0] > 1e-5).all()
    np.testing.assert_allclose(off[1:4], 0.0, atol=1e-5)


def test_a_motor_that_rubs_in_a_dead_zone_stops_short_by_the_larger_of_both() -> None:
    arm = load_model("trunk").arm
    zone = {"on": ["position"] * 5, "low": np.full(5, -1.0), "high": np.full(5, 1.0)}
    zone |= {p.name: np.full(5, 3e-3) for p in VALUES}
    commands = np.tile(np.interp(STAMP, [1.0, 4.0], [0.0, 0.3])[:, None], (1, 5))
    model = Model(arm, {"unknown_dead_zone": zone, "motor_friction": {"friction": 5e-3}})
    stands = Chain(model, "servo").run(commands, STAMP)[0][-1]
    sent = [RealityLayer(Model(arm, some)) for some in (model.effects, {})]
    with_them, without = (
        [layer.step(one, one * arm.ratio, 1 / RATE)[0] for one in commands][-1] for layer in sent
    )
    np.testing.assert_allclose(without - with_them, commands[-1] - stands, rtol=0.05)


def test_what_the_simulator_has_is_not_added_again() -> None:
    arm = load_model("direct").for_joints(("a", "b")).arm
    simulation = Model(
        arm, {"backlash": {"half_width": np.array([1e-3, 5e-3])}, "sensor_delay": {"delay": 0.01}}
    )
    model = Model(arm, {"backlash": {"half_width": np.array([4e-3, 2e-3])}, "sensor_delay": {"delay": 0.03}})
    lacking = missing(model, simulation)
    assert lacking.model.effects["backlash"]["half_width"] == pytest.approx([3e-3, 0.0])
    assert lacking.model.effects["sensor_delay"]["delay"] == pytest.approx(0.02)
    assert "backlash" in lacking.remarks[0]
    assert "b 0.003 rad" in lacking.remarks[0]


def test_a_wrong_shape_is_refused_in_one_line() -> None:
    layer = RealityLayer(load_model("trunk"), 2)
    with pytest.raises(ModelError, match=r"command has the shape \(5,\): it must be for 2 environments"):
        layer.step(np.zeros(5), np.zeros((2, 5)), 0.01)
    with pytest.raises(ModelError, match="wants a model with joints"):
        RealityLayer("direct")


def test_what_is_no_number_is_refused_with_its_place() -> None:
    layer = RealityLayer(load_model("trunk"), environments=3)
    state = np.zeros((3, 5))
    state[1, 2] = np.nan
    with pytest.raises(ModelError, match="state of joint_3 in environment 1 is no number"):
        layer.step(np.zeros((3, 5)), state, 0.01)


def test_all_effects_of_the_wire_but_the_one_by_hand_are_covered() -> None:
    assert {name for name, _ in HELD} | {"distributed_wire"} == {name for name, _ in WIRE}
    assert not effect("distributed_wire").tried
