"""The servo loop against the equations of docs/physics.md, stepped in plain Python."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from test.effects.example import arm_of, motion, stamps
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects.servo.asked import EDGE, beyond
from trunk_ros.effects.servo.loop import servo_loop
from trunk_ros.effects.servo.loops import servo_loops
from trunk_ros.model import Model, load_model
from trunk_ros.nodes.bus import SimulatedBus
from trunk_ros.servo_run import speeds

STEP = 0.002  # s
OVER_TIME = (2, 3, 4, 5, 6, 9, 10, 13, 14, 15)  # arguments of a loop that may change


def reference(setpoint: Array, rows: int, kp: float = 20.0, tau: float = 0.02, v_max: float = 1.5) -> Array:
    """Gearbox angle (n,) at setpoints (n,) that come every ``rows`` steps of 2 ms: v first, then phi with
    the new v.
    """
    phi, v, out = float(setpoint[0]), 0.0, []
    for target in setpoint.tolist():
        out.append(phi)
        for _ in range(rows):
            v_ref = min(max(kp * (target - phi), -v_max), v_max)
            v += STEP * (v_ref - v) / tau
            phi += STEP * v
    return np.array(out)


def servo(setpoint: Array, stamp: Array, **effects: Any) -> Array:
    """Gearbox angles (n, joints) of the servo stage."""
    return Chain(Model(arm_of(setpoint.shape[1]), effects), "servo").run(setpoint, stamp)[0]


def steps_and_sweeps(rate: float) -> tuple[Array, Array]:
    """Stamps, and setpoints with a jump that saturates the speed."""
    stamp = stamps(6, rate)
    setpoint = motion(stamp, 2) / 0.625
    setpoint[stamp > 3.0] += [0.5, -0.2]
    return stamp, setpoint


@pytest.mark.parametrize("rows", [1, 2, 5, 10])
def test_it_is_the_reference_integration(rows: int) -> None:
    stamp, setpoint = steps_and_sweeps(500.0 / rows)
    got = servo(setpoint, stamp)
    for joint in range(2):
        assert got[:, joint] == pytest.approx(reference(setpoint[:, joint], rows), abs=1e-12)


@pytest.mark.parametrize(
    ("effect", "values", "changed"),
    [
        ("servo_bandwidth", {"relative": -0.3}, {"kp": 14.0}),
        ("velocity_saturation", {"v_max": 0.4}, {"v_max": 0.4}),
        ("velocity_saturation", {"v_max": 3.0}, {"v_max": 3.0}),
        ("velocity_saturation", {"v_max": 1e3}, {}),
        ("velocity_loop", {"relative": 0.5}, {"tau": 0.03}),
    ],
)
def test_a_changed_loop_is_the_same_integration(effect: str, values: Any, changed: Any) -> None:
    stamp, setpoint = steps_and_sweeps(100.0)
    got = servo(setpoint, stamp, **{effect: values})
    assert got[:, 0] == pytest.approx(reference(setpoint[:, 0], 5, **changed), abs=1e-12)


def test_a_setpoint_acts_from_its_stamp_on() -> None:
    stamp = stamps(0.1, 100)
    setpoint = np.where(stamp[:, None] >= 0.05 - 1e-9, 0.1, 0.0)
    phi = servo(setpoint, stamp)[:, 0]
    assert phi[stamp < 0.051].tolist() == [0.0] * 6, "read before the setpoint of that stamp acts"
    assert phi[6] > 0.0


@pytest.mark.parametrize("delay", [0.01, 0.02])
def test_a_delay_of_whole_samples_shifts_the_setpoints(delay: float) -> None:
    stamp, setpoint = steps_and_sweeps(100.0)
    late = round(delay * 100)
    shifted = np.concatenate([np.repeat(setpoint[:1], late, axis=0), setpoint[:-late]])
    assert servo(setpoint, stamp, servo_delay={"delay": delay}) == pytest.approx(
        servo(shifted, stamp), abs=1e-9
    )


@pytest.mark.parametrize("columns", [1, 5])
def test_late_setpoints_act_in_full_whatever_rows_lie_between_them(columns: int) -> None:
    """Rows at which the shaft is read, just before setpoints: they had hidden these from the step's mean."""
    stamp = 0.01 * np.arange(300)
    asked = np.tile(0.5 * np.sin(2.0 * stamp)[:, None], (1, columns))
    rows = np.unique(np.concatenate([stamp, stamp[1:] - 4e-4]))
    held = asked[np.searchsorted(stamp, rows + 1e-9, side="right") - 1]
    whole, read = (servo(a, t, servo_delay={"delay": 5e-3}) for a, t in ((asked, stamp), (held, rows)))
    assert read[np.searchsorted(rows, stamp - 1e-9)] == pytest.approx(whole, abs=2e-4)


def test_a_delay_may_be_longer_than_a_block() -> None:
    stamp, setpoint = steps_and_sweeps(100.0)
    chain = Chain(Model(arm_of(2), {"servo_delay": {"delay": 0.137}}), "servo")
    state, parts = None, []
    for begin in range(0, len(stamp), 3):
        part, state = chain.run(setpoint[begin : begin + 3], stamp[begin : begin + 3], state)
        parts.append(part)
    assert np.concatenate(parts) == pytest.approx(chain.run(setpoint, stamp)[0], abs=1e-12)


def test_the_load_pulls_the_shaft_off_its_setpoint() -> None:
    arm = arm_of(3)
    stamp = stamps(5, 100)
    setpoint = np.tile([0.4, 0.2, -0.1], (len(stamp), 1))
    phi = servo(setpoint, stamp, load_droop={"gain": 0.1})[-1]
    assert phi == pytest.approx(setpoint[0] + 0.1 * arm.load((phi * 0.625)[None])[0], abs=1e-6)


def test_friction_that_the_motor_pulls_holds_the_shaft_back_on_either_side() -> None:
    """Once the wire slides, by gain times friction, against the motion; it stays so at rest."""
    arm, stamp = arm_of(3), stamps(10, 100)
    up = np.interp(stamp, [0.0, 3.0, 10.0], [0.0, 0.3, 0.3])
    droop = {"gain": 0.02, "friction": np.array([0.1, 0.2, 0.0]), "form": "weight_and_friction"}
    for setpoint, side in ((up, 1.0), (0.3 - up, -1.0)):
        asked = np.tile(setpoint[:, None], (1, 3))
        phi = servo(asked, stamp, load_droop=droop)[-1]
        weight = 0.02 * arm.load((phi * 0.625)[None])[0]
        assert phi - weight == pytest.approx(asked[-1] - side * 0.02 * droop["friction"], abs=1e-4)


def test_a_wire_that_sticks_keeps_a_load_that_changes_from_the_motor() -> None:
    """What the wire of the first joint bears moves its motor only once its friction has given way."""
    arm, stamp = arm_of(3), stamps(10, 100)
    asked = np.zeros((len(stamp), 3))
    asked[:, 1] = np.interp(stamp, [0.0, 2.0, 8.0], [0.0, 0.0, 0.5])
    bears = {"gain": 0.02, "form": "weight_and_friction"}
    change = arm.load(asked * 0.625)[-1, 0]
    holds = servo(asked, stamp, load_droop={**bears, "friction": 1.2 * abs(change)})[:, 0]
    assert np.abs(holds).max() < 1e-9
    gives = servo(asked, stamp, load_droop={**bears, "friction": 0.4 * abs(change)})[:, 0]
    assert gives[-1] == pytest.approx(0.02 * 0.6 * change, rel=0.02)
    blocks, state, chain = [], None, Chain(Model(arm, {"load_droop": {**bears, "friction": 0.03}}), "servo")
    for rows in np.array_split(np.arange(len(stamp)), 7):
        out, state = chain.run(asked[rows], stamp[rows], state)
        blocks.append(out)
    whole = servo(asked, stamp, load_droop={**bears, "friction": 0.03})
    assert np.concatenate(blocks) == pytest.approx(whole, abs=1e-6)


def test_a_run_begins_with_friction_where_it_holds_the_shaft() -> None:
    """What the first angle and setpoint leave of the load is borne by friction, as far as it goes."""
    arm, stamp = arm_of(3), stamps(4, 100)
    asked = np.tile([0.4, 0.2, -0.1], (len(stamp), 1))
    load = arm.load(asked * 0.625)[0]
    for share in (0.5, 1.5):
        droop = {"gain": 0.02, "friction": share * np.abs(load), "form": "weight_and_friction"}
        moved = servo(asked, stamp, load_droop=droop)[-1] - asked[-1]
        assert moved == pytest.approx(0.02 * max(1.0 - share, 0.0) * load, rel=0.1, abs=1e-9)


def test_servos_bear_the_load_of_joints_that_sag() -> None:
    """And not that of where the gearboxes alone would have them; in one go as in blocks."""
    arm, stamp = arm_of(3), stamps(4, 100)
    asked = np.tile([0.4, 0.2, -0.1], (len(stamp), 1)) * np.minimum(stamp, 1.0)[:, None]
    effects = {"load_droop": {"gain": 0.05}, "load_elasticity": {"compliance": 0.2}}
    model = Model(arm, effects)
    phi = Chain(model, "servo").run(asked, stamp)[0]
    joints = Chain(model, "wire").angles(phi, stamp)
    assert phi[-1] == pytest.approx(asked[-1] + 0.05 * arm.load(joints)[-1], abs=1e-6)
    assert np.abs(arm.load(joints) - arm.load(phi * 0.625))[-1].max() > 1e-3
    chain, state, blocks = Chain(model, "servo"), None, []
    for rows in np.array_split(np.arange(len(stamp)), 5):
        out, state = chain.run(asked[rows], stamp[rows], state)
        blocks.append(out)
    assert np.concatenate(blocks) == pytest.approx(phi, abs=1e-6)


def test_a_torque_slows_a_shaft_that_the_limit_of_its_speed_holds() -> None:
    """Not so what acts before the limit."""
    arm, stamp = arm_of(3), stamps(2, 500)
    asked = np.zeros((len(stamp), 3))
    asked[50:, 0] = 2.0
    speed = {}
    for share in (0.0, 1.0):
        out = servo(asked, stamp, load_droop={"gain": 0.05, "as_torque": share})[:, 0]
        speed[share] = (out[600] - out[500]) / (stamp[600] - stamp[500]), out[500:600]
    pulled = arm.kp * 0.05 * arm.load(np.column_stack([speed[1.0][1], *np.zeros((2, 100))]) * 0.625)[:, 0]
    assert speed[0.0][0] == pytest.approx(arm.v_max, rel=1e-3)
    assert speed[1.0][0] == pytest.approx(arm.v_max + pulled.mean(), rel=1e-2)
    assert abs(pulled.mean()) > 0.02


def test_cogging_shifts_where_the_shaft_stands() -> None:
    stamp = stamps(5, 100)
    setpoint = np.tile(np.linspace(-0.3, 0.3, 5), (len(stamp), 1))
    phi = servo(setpoint, stamp, cogging={"amplitude": 1e-3, "cycles_per_rev": 24.0})[-1]
    assert phi == pytest.approx(setpoint[0] + 1e-3 * np.sin(24.0 * phi), abs=1e-6)


@settings(max_examples=20, deadline=None)
@given(gaps=st.lists(st.floats(0.0005, 0.08), min_size=5, max_size=40))
def test_uneven_setpoints_are_held_until_the_next(gaps: list[float]) -> None:
    """A chain asked at further times between the setpoints passes through the same states, to the
    integrator's step.
    """
    stamp = np.cumsum([0.0, *gaps])
    setpoint = motion(stamp * 5, 1)
    dense = np.sort(np.concatenate([stamp, stamp[:-1] + np.diff(stamp) / 2]))
    held = setpoint[np.searchsorted(stamp, dense + 1e-12, side="right") - 1]
    at = np.searchsorted(dense, stamp)
    assert servo(held, dense)[at] == pytest.approx(servo(setpoint, stamp), abs=2e-3)


def test_a_curve_over_speed_acts_where_the_angle_is_not_known_beforehand() -> None:
    """Setpoints shifted by 10 ms of the joint's speed: at a constant one the shaft is as far ahead."""
    stamp = np.arange(300) * 0.01
    setpoint = np.minimum(stamp, 2.0)[:, None] * np.array([0.2, -0.3])
    shift = {f"value_{k:02}": np.full(2, 0.01 * v) for k, v in enumerate(np.linspace(-1.0, 1.0, 24))}
    curve = {"low": np.full(2, -1.0), "high": np.full(2, 1.0), **shift, "on": ["speed", "speed"]}
    ahead = servo(setpoint, stamp, unknown_servo=curve) - servo(setpoint, stamp)
    expected = 0.01 * arm_of(2).ratio * np.array([0.2, -0.3])
    np.testing.assert_allclose(ahead[150:200].mean(axis=0), expected, rtol=0.02)


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("servo_bandwidth", {"relative": -0.4}),
        ("servo_delay", {"delay": 0.05}),
        ("velocity_saturation", {"v_max": 0.3}),
        ("load_droop", {"gain": 0.05, "form": "weight"}),
        ("cogging", {"amplitude": 2e-3, "cycles_per_rev": 24.0, "phase": np.zeros(2)}),
    ],
)
@pytest.mark.parametrize("moment", ["from", "until"])
def test_what_begins_or_ends_in_mid_run_is_the_servo_with_it_and_without_one_after_the_other(
    effect: str, values: Any, moment: str
) -> None:
    stamp, setpoint = steps_and_sweeps(200.0)
    other = Model(arm_of(2), {effect: values})
    models = [Model(arm_of(2)), other] if moment == "from" else [other, Model(arm_of(2))]
    half = int(np.searchsorted(stamp, 3.2))
    first, state = Chain(models[0], "servo").run(setpoint[:half], stamp[:half])
    then, _ = Chain(models[1], "servo").run(setpoint[half:], stamp[half:], state)
    whole = Chain(Model(arm_of(2), {effect: {**values, moment: 3.2}}), "servo").run(setpoint, stamp)[0]
    size = np.abs(
        Chain(models[0], "servo").run(setpoint, stamp)[0] - Chain(models[1], "servo").run(setpoint, stamp)[0]
    )
    np.testing.assert_allclose(whole[: half - 3], first[:-3], atol=1e-12)
    off = np.abs(whole[half:] - then)
    assert off.max() < 0.1 * size.max()
    assert off[-100:].max() < 2e-3 * size.max()


@pytest.mark.parametrize("late", [0.0101, 0.0113, 0.0119])
@pytest.mark.parametrize("columns", [1, 4])
def test_a_late_jump_begins_to_be_followed_when_it_is_there(late: float, columns: int) -> None:
    """At the top speed the mean of the setpoints of a step says nothing of when in it they jump."""
    kp, tau, v_max, fine, stamp = 20.0, 0.02, 1.5, 1e-5, stamps(2, 100.0)
    setpoint = np.repeat(np.where(stamp >= 0.2, 1.0, 0.0)[:, None], columns, axis=1)
    arm = replace(arm_of(columns), kp=kp, tau_v=tau, v_max=v_max, delay=late, step=0.0)
    got = Chain(Model(arm), "servo").run(setpoint, stamp)[0]
    phi, v, out = 0.0, 0.0, []
    for k in range(len(stamp) * 1000):
        if k % 1000 == 0:
            out.append(phi)
        asked = 1.0 if k * fine >= 0.2 + late - 1e-9 else 0.0
        v += fine * (min(max(kp * (asked - phi), -v_max), v_max) - v) / tau
        phi += fine * v
    assert np.abs(got - np.array(out)[:, None]).max() < 2e-4


@pytest.mark.parametrize("limited", [0.0, 1.0, 9.0])
@pytest.mark.parametrize(("summing", "fed"), [(0.0, False), (30.0, False), (30.0, True)])
@pytest.mark.parametrize(("held", "ahead"), [(0.0, 0.0), (0.004, 0.0), (0.0, 0.5), (0.004, 0.2)])
def test_joints_side_by_side_come_out_as_each_by_itself(
    held: float, ahead: float, limited: float, summing: float, fed: bool
) -> None:
    columns, rng = 6, np.random.default_rng(3)
    stamp = np.cumsum(rng.choice([0.004, 0.01, 0.011, 0.09], size=400))
    setpoint = np.cumsum(rng.normal(scale=0.02, size=(len(stamp), columns)), axis=0)
    each, reach = np.linspace(0.5, 1.5, columns), 0.01 if held else 0.0
    delay = np.array([0.0, 0.013, 0.013, 0.2, 0.2, 0.0])
    arguments: list[Array] = [
        setpoint, stamp, 20.0 * each, 0.02 * each, 1.5 * each, 1.2 * each, delay,
        rng.normal(scale=1e-3, size=setpoint.shape), rng.normal(scale=1e-3, size=setpoint.shape),
        0.3 * each, held * each, reach * each,
        np.full(setpoint.shape, held) * (each > 1.0), np.array([1e-3 * each, 22.0 * each, each]),
        np.vstack([
            np.where(limited * each > 1.0, [0.5 * each, 9.0 * each], np.inf),
            np.outer([0.5 * held, 0.1], each),
            [np.where(limited * each > 1.3, 3.0 * each, np.inf), 0.03 * each, 0.2 * summing * (each > 0.9)],
        ]),
        np.where(each > 0.7, summing * each, 0.0),
        rng.normal(scale=1e-3, size=setpoint.shape)[: len(setpoint) if fed else 0],
    ]  # fmt: skip
    arguments[2][1] = 300.0  # stiff: stepped finer than the others
    together, start = np.empty_like(setpoint), rng.normal(size=(8, columns))
    start[-2:] = np.where(np.arange(columns) % 2, np.nan, start[-2:])
    after = start.copy()
    servo_loops(*arguments, ahead, 0, after, together)
    for j in range(columns):
        some = [a if a is stamp else np.ascontiguousarray(a[..., j : j + 1]) for a in arguments]
        some = [a[..., None, :] if k in OVER_TIME else a for k, a in enumerate(some)]
        alone, state = np.empty((len(stamp), 1)), start[:, j : j + 1].copy()
        servo_loop(*some, ahead, 0, state, alone)
        assert np.array_equal(alone[:, 0], together[:, j])
        assert np.array_equal(state[:, 0], after[:, j], equal_nan=True)


@pytest.mark.parametrize("rate", [200.0, 1000.0 / 3.0])
def test_stamps_that_are_rounded_are_stepped_as_those_that_are_not(rate: float) -> None:
    """Two and a half steps between two rows, and one and a half: halves once went up or down by chance."""
    count = np.arange(int(8.0 * rate))
    exact, read = count / rate, 1e-9 * np.rint(count * 1e9 / rate)
    setpoint = np.outer(np.sin(2.0 * exact) + (exact > 4.0), [0.6, -0.4])
    one, other = servo(setpoint, exact), servo(setpoint, read + 1000.0)
    assert one == pytest.approx(other, abs=1e-7)


def test_a_dead_zone_lets_through_what_is_beyond_its_edge() -> None:
    errors, zone = np.linspace(-0.02, 0.02, 4001), 0.01
    through = errors * np.clip((np.abs(errors) / zone - 1.0) / EDGE + 0.5, 0.0, 1.0)
    assert np.array_equal([beyond(error, zone) for error in errors], through)


@pytest.mark.parametrize("later", [0.0, 0.002, 0.009])
def test_a_setpoint_has_one_speed_whatever_rows_it_stands_in(later: float) -> None:
    """Rows between setpoints: the speed is that from the one before, until the next is due."""
    stamp = 0.01 * np.arange(200)
    asked = 0.5 * np.minimum(stamp, 1.0)[:, None]
    rows = np.unique(np.concatenate([stamp, stamp + later]))
    held = asked[np.searchsorted(stamp, rows + 1e-9, side="right") - 1]
    told, moves = speeds(held, rows)[:, 0], rows[1:] < 1.0
    assert np.allclose(told[moves & (rows[1:] >= 0.0100001 - 1e-6)], 0.5)
    assert np.all(told[rows[1:] > 1.0101] == 0.0)


def test_a_stand_does_not_slow_the_first_setpoint_after_it() -> None:
    stamp = 0.01 * np.arange(300)
    asked = 0.5 * (np.minimum(stamp, 1.0) + np.maximum(stamp - 2.0, 0.0))[:, None]
    told = speeds(asked, stamp)[:, 0]
    assert told[200] == pytest.approx(0.5)


def test_a_servo_in_pieces_feeds_forward_as_in_one() -> None:
    model = load_model("trunk")
    model = replace(model, arm=replace(model.arm, feedforward=0.8))
    stamp = 0.01 * np.arange(300)
    asked = np.tile(0.1 * (1.0 - np.cos(2.0 * stamp))[:, None], (1, len(model.arm.joints)))
    whole, _ = Chain(model, "servo").run(asked, stamp)
    bus = SimulatedBus(model)
    read = []
    for at, setpoint in zip(stamp, asked, strict=True):
        read.append(bus.read(at).position)
        bus.write(setpoint, at)
    late = np.array(read)[1:] - whole[1:]
    plain, _ = Chain(load_model("trunk"), "servo").run(asked, stamp)
    assert np.abs(late).max() < 0.1 * np.abs(plain - whole).max()


def test_speed_that_is_fed_beside_the_models_own_is_as_if_the_model_had_both() -> None:
    stamp, setpoint = steps_and_sweeps(100.0)
    asked = setpoint[:, :1]
    for own, more, both in ((0.0, 0.6, 0.6), (0.5, 0.3, 0.8), (0.5, -0.9, 0.0)):
        told = Model(replace(arm_of(1), feedforward=own), {"speed_feedforward": {"share": more}})
        went = Chain(told, "servo").run(asked, stamp)[0]
        plain = Model(replace(arm_of(1), feedforward=both))
        assert told.number("feedforward") == pytest.approx(both)
        assert went == pytest.approx(Chain(plain, "servo").run(asked, stamp)[0], abs=1e-12)


def test_a_servo_that_is_faster_one_way_drifts_that_way_under_fast_moves() -> None:
    stamp, arm = stamps(4, 100.0), replace(arm_of(1), kp=20.0, tau_v=0.005, v_max=2.0)
    setpoint = np.where(np.floor(stamp / 0.2) % 2 == 0.0, 1.0, -1.0)[:, None]
    setpoint[0] = 0.0
    told = Model(arm, {"uneven_speed": {"excess": np.array([0.25])}})
    went = Chain(told, "servo").run(setpoint, stamp)[0][:, 0]
    speed = np.gradient(went, stamp)
    assert speed.max() == pytest.approx(2.5, rel=0.01)
    assert speed.min() == pytest.approx(-1.5, rel=0.01)
    assert went[-40:].mean() > went[:40].mean() + 0.1
