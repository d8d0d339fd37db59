"""The chain: memory, time, joints that see each other, and the way back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from test.effects.example import COMPENSABLE, alike, arm_of, everything, in_plane, model_of, motion, stamps
from trunk_ros.chain import Chain, State, tip_pass, wire_pass
from trunk_ros.compiled import Array
from trunk_ros.effects import registry
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model
from trunk_ros.stage import Order

NOISE_FLOOR = 1e-5  # rad
AGREED = 4e-6  # rad: what blocks and ticks may differ by, where joints see each other through three couplings


def nominal_play(phi: Array, ratio: Array, width: Array) -> Array:
    """The nominal wire of docs/physics.md in plain Python."""
    theta, out = ratio * phi[0], []
    for row in ratio * phi:
        theta = np.clip(theta, row - width, row + width)
        out.append(theta)
    return np.array(out)


def test_the_nominal_wire_is_a_play() -> None:
    model = load_model("trunk")
    phi = motion(stamps(30, 100)) / model.arm.ratio
    got, _ = Chain(model, "wire").run(phi, stamps(30, 100))
    alike(got, nominal_play(phi, model.arm.ratio, model.arm.dead_band), 1e-15)


def test_a_direct_transmission_hands_on_what_it_gets() -> None:
    model = load_model("direct").for_joints(("a", "b"))
    x = motion(stamps(3, 100), 2)
    assert np.array_equal(Chain(model, "wire").run(x, stamps(3, 100))[0], x)


def test_an_unknown_stage_is_refused() -> None:
    with pytest.raises(ModelError, match="unknown stage 'motor': choose wire, servo or arm"):
        Chain(Model(arm_of(2)), "motor")


def test_a_signal_without_samples_is_refused() -> None:
    with pytest.raises(ModelError, match="no samples"):
        Chain(Model(arm_of(2)), "wire").run(np.empty((0, 2)), np.empty(0))


@pytest.mark.parametrize("stage", ["servo", "arm"])
def test_only_the_wire_has_an_inverse(stage: str) -> None:
    with pytest.raises(ModelError, match="has no inverse"):
        Chain(Model(arm_of(2)), stage).invert(np.zeros((1, 2)), np.zeros(1))


@pytest.fixture(scope="module")
def under_way() -> tuple[Array, list[Array]]:
    """A motion, and what all effects at once make of the whole of it, forward and backward."""
    chain, stamp = Chain(everything(), "wire"), stamps(6, 100)[:-1]
    wanted = motion(stamp + 1.0, amplitude=0.15)
    return wanted, [way(wanted, stamp)[0] for way in (chain.run, chain.invert)]


@settings(max_examples=2, deadline=None)
@given(cuts=st.sets(st.integers(1, 599), min_size=1, max_size=12))
def test_all_effects_at_once_work_block_by_block(
    under_way: tuple[Array, list[Array]], cuts: set[int]
) -> None:
    chain, stamp = Chain(everything(), "wire"), stamps(6, 100)[:-1]
    wanted, whole = under_way
    for way, expected in zip((chain.run, chain.invert), whole, strict=True):
        state: State | None = None
        parts = []
        for part in np.split(np.arange(600), sorted(cuts)):
            out, state = way(wanted[part], stamp[part], state)
            parts.append(out)
        alike(np.concatenate(parts), expected, AGREED)


def test_a_long_recording_is_cut_into_blocks_that_do_not_show() -> None:
    chain, stamp = Chain(everything(2), "wire"), np.arange(25_000) * 0.01
    x = motion(stamp, 2) / 0.625
    by_tens = [chain.run(x[:12_345], stamp[:12_345])]
    by_tens.append(chain.run(x[12_345:], stamp[12_345:], by_tens[0][1]))
    whole = chain.run(x, stamp)[0]
    alike(np.concatenate([part for part, _ in by_tens]), whole, AGREED)


def test_single_ticks_are_the_recording() -> None:
    chain, stamp = Chain(everything(), "wire"), stamps(4, 100)
    x = motion(stamp) / 0.625
    state, ticks = None, []
    for k in range(len(stamp)):
        out, state = chain.run(x[k : k + 1], stamp[k : k + 1], state)
        ticks.append(out)
    alike(np.concatenate(ticks), chain.run(x, stamp)[0], 2 * AGREED)


def test_a_state_can_be_used_twice() -> None:
    chain, stamp = Chain(everything(), "wire"), stamps(4, 100)
    x = motion(stamp) / 0.625
    _, state = chain.run(x[:200], stamp[:200])
    first, _ = chain.run(x[200:], stamp[200:], state)
    second, _ = chain.run(x[200:], stamp[200:], state)
    assert np.array_equal(first, second)


@pytest.mark.parametrize("joints", [1, 2, 5, 7])
def test_the_whole_chain_backward_then_forward_gives_what_was_wanted(joints: int) -> None:
    chain, stamp = Chain(everything(joints), "wire"), stamps(6, 100)
    wanted = motion(stamp, joints, amplitude=0.15)
    gearbox, _ = chain.invert(wanted, stamp)
    got, _ = chain.run(gearbox, stamp)
    off = np.abs(got - wanted)  # it leaps where a motor turns back and friction falls
    assert np.sqrt(np.mean(off**2)) < NOISE_FLOOR
    assert np.quantile(off, 0.99) < 2 * NOISE_FLOOR


def test_a_late_sensor_is_left_out_of_the_inverse() -> None:
    stamp = stamps(4, 100)
    wanted = motion(stamp)
    late = Chain(model_of("sensor_delay"), "wire").invert(wanted, stamp)[0]
    assert np.array_equal(late, Chain(Model(arm_of(5)), "wire").invert(wanted, stamp)[0])


def test_the_inverse_sees_the_load_at_the_true_angle_not_at_a_reading_with_an_offset() -> None:
    effects = {
        "load_elasticity": {"compliance": np.full(5, 0.05)},
        "zero_offset": {"offset": np.full(5, 0.3)},
    }
    chain, stamp = Chain(Model(arm_of(5), effects), "wire"), stamps(8, 100)
    wanted = motion(stamp) + 0.3
    alike(chain.run(chain.invert(wanted, stamp)[0], stamp)[0], wanted, 1e-7)


def test_rounding_in_a_reference_does_not_cross_the_dead_band() -> None:
    chain = Chain(Model(arm_of(1)), "wire")
    stamp = stamps(2, 100)
    wanted = np.minimum(stamp, 1.0)[:, None] * 0.1 + 1e-12 * np.random.default_rng(1).normal(
        size=(len(stamp), 1)
    )
    gearbox, _ = chain.invert(wanted, stamp)
    assert np.ptp(gearbox[stamp > 1.0]) < 1e-8


def test_live_nodes_hold_effects_of_time_at_the_end_of_the_fitted_recording() -> None:
    drift = {"thermal_drift": {"rate": np.full(1, 1e-3), "form": "straight"}}
    chain = Chain(Model(arm_of(1, 0.0), drift, duration=60.0), "wire", hold_time=True)
    shown = [chain.run(np.zeros((1, 1)), np.array([t]))[0][0, 0] for t in (0.0, 500.0)]
    assert shown == pytest.approx([0.06, 0.06])


def test_filters_and_delays_go_on_while_time_is_held() -> None:
    effects: dict[str, Any] = {
        "sensor_delay": {"delay": 0.013},
        "viscous_lag": {"time_constant": np.full(2, 0.05)},
        "stribeck_friction": {"amplitude": np.full(2, 1e-3), "velocity": np.full(2, 0.05)},
    }
    stamp = stamps(4, 100)
    x = motion(stamp, 2)
    model = Model(arm_of(2), effects, duration=60.0)
    live, state, ticks = Chain(model, "wire", hold_time=True), None, []
    for k in range(len(stamp)):
        out, state = live.run(x[k : k + 1], stamp[k : k + 1], state)
        ticks.append(out)
    alike(np.concatenate(ticks), Chain(model, "wire").run(x, stamp)[0], 1e-9)


def test_the_chain_and_one_pass_over_its_columns_agree() -> None:
    """What the diagnosis does: one joint at a time, with what it needs of the others handed to it."""
    model = Model(arm_of(3), {name: model_of(name, form, 3).effects[name] for name, form in COMPENSABLE[:8]})
    stamp = stamps(8, 100)
    x = motion(stamp, 3) / 0.625
    chain = Chain(model, "wire")
    shown, _ = chain.run(x, stamp)
    angles = chain.angles(x, stamp)
    dt = np.diff(stamp, prepend=0.0)
    speed = np.diff(x, axis=0, prepend=x[:1]) * 0.625
    speed[1:] /= dt[1:, None]
    for column in range(3):
        cut = slice(column, column + 1)
        now = Now(
            stamp, dt, x[:, cut], speed[:, cut], model.arm.load(angles)[:, cut], angles, x * model.arm.ratio,
            model.arm.joints, model.arm.ratio[cut],
        )  # fmt: skip
        effects = [
            kind({k: v[cut] for k, v in e.values.items()}, {k: w[cut] for k, w in e.words.items()}, e.form)
            for e in chain.effects
            for kind in [registry()[e.id]]
        ]
        width = model.arm.dead_band[None, cut]
        got, _, _ = wire_pass(
            np.ascontiguousarray(x[:, cut]),
            now,
            Order.of(effects),
            Core(nominal_width=width, width=width),
            None,
        )
        alike(got[:, 0], shown[:, column], AGREED)


def test_the_nominal_tip_is_the_arms_forward_kinematics() -> None:
    model = load_model("trunk")
    theta = motion(stamps(3, 100))
    tip = Chain(model, "arm").run(theta, stamps(3, 100))[0]
    assert tip == pytest.approx(model.arm.tip(theta))


def test_a_longer_link_and_a_tilted_base_move_the_tip() -> None:
    arm = arm_of(2)
    effects = {"link_length_error": {"length_error": np.array([0.01, 0.0])}, "base_tilt": {"angle": 0.2}}
    theta = np.array([[0.3, -0.1]])
    tip = Chain(Model(arm, effects), "arm").tip(theta, np.zeros(1))[0]
    first, second = 0.125 + 0.01, 0.125
    y = -first * np.sin(0.5) - second * np.sin(0.4)
    z = first * np.cos(0.5) + second * np.cos(0.4)
    assert in_plane(tip[None])[0] == pytest.approx([y, z, 0.4])


def test_a_model_without_links_has_no_tip() -> None:
    model = load_model("direct").for_joints(("a",))
    with pytest.raises(ModelError, match=r"neither arm\.urdf nor arm\.link_length"):
        Chain(model, "arm").tip(np.zeros((1, 1)), np.zeros(1))


def test_tip_and_chain_agree_on_an_arm_without_effects() -> None:
    arm, theta = arm_of(4), motion(stamps(1, 50), 4)
    assert tip_pass(arm, [], theta, Now(*[np.zeros(0)] * 7, arm.joints, arm.ratio)).shape == (51, 7)
