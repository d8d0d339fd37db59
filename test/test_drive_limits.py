"""Drives that clip or ramp setpoints, and setpoints that are stamped late, against plain Python."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.effects.example import arm_of
from test.test_servos_that_change import surroundings
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects.servo.loop import fresh
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries
from trunk_ros.servo_course import servo_course
from trunk_ros.servo_run import run_servo, servo_core, with_profiles

KP, TAU, FINE = 20.0, 0.02, 1e-4
RATE = 100.0


def asked(seconds: float = 5.0) -> tuple[Array, Array]:
    """Stamps (n,) and setpoints (n, 2): steps, and a sweep that gets fast."""
    stamp = np.arange(0.0, seconds, 1.0 / RATE)
    steps = np.where(stamp > 0.5, 0.5, 0.0) - np.where(stamp > 2.5, 0.8, 0.0)
    return stamp, np.column_stack([steps, 0.4 * np.sin(2.0 * stamp**2 / 3.0)])


def servo(setpoint: Array, stamp: Array, **effects: Any) -> Array:
    """Gearbox angles (n, joints) of loops that run as if without end, far from their top speed."""
    arm = replace(arm_of(setpoint.shape[1]), kp=KP, tau_v=TAU, v_max=50.0, step=0.0)
    return Chain(Model(arm, effects), "servo").run(setpoint, stamp)[0]


def in_steps(setpoint: Array, rate: float = np.inf, hardest: float = np.inf, dry: float = 0.0) -> Array:
    """The same of a joint (n,), in steps of 0.1 ms."""
    phi, v, led, out = setpoint[0], 0.0, setpoint[0], []
    for target in setpoint:
        out.append(phi)
        for _ in range(round(1.0 / RATE / FINE)):
            led += np.clip(target - led, -rate * FINE, rate * FINE)
            v += np.clip((KP * (led - phi) - v) / TAU, -hardest, hardest) * FINE
            v -= np.clip(v, -KP * dry / TAU * FINE, KP * dry / TAU * FINE)
            phi += v * FINE
    return np.array(out)


def test_a_drive_that_clips_its_setpoints_is_one_that_gets_clipped_ones() -> None:
    stamp, setpoint = asked()
    upper, lower = np.array([0.3, 0.2]), np.array([-0.1, -0.4])
    clipped = np.clip(setpoint, lower, upper)
    limits = {"setpoint_ceiling": {"upper": upper}, "setpoint_floor": {"lower": lower}}
    assert np.array_equal(servo(setpoint, stamp, **limits), servo(clipped, stamp))
    above = servo(setpoint, stamp, setpoint_ceiling={"upper": 0.3})
    assert np.array_equal(above, servo(np.minimum(setpoint, 0.3), stamp))


@pytest.mark.parametrize("rate", [0.2, 0.7])
def test_a_drive_that_ramps_its_setpoint_does_so_between_two_that_it_gets(rate: float) -> None:
    stamp, setpoint = asked()
    got = servo(setpoint, stamp, setpoint_rate={"rate": rate, "form": "drive"})
    for j in range(2):
        assert got[:, j] == pytest.approx(in_steps(setpoint[:, j], rate), abs=4e-4)
    assert np.abs(got - servo(setpoint, stamp)).max() > 0.1


def test_a_controller_that_limits_each_setpoint_goes_on_while_they_stand() -> None:
    """In whatever rows they stand."""
    stamp, setpoint = asked()
    limited, rate = setpoint.copy(), 0.7
    for k in range(1, len(limited)):
        most = rate / RATE
        limited[k] = limited[k - 1] + np.clip(setpoint[k] - limited[k - 1], -most, most)
    values = {"rate": rate, "form": "each_setpoint"}
    late = np.sort(np.concatenate([stamp, stamp + 0.004]))
    rows = np.searchsorted(stamp, late + 1e-9, side="right") - 1
    got = servo(setpoint[rows], late, setpoint_rate=values)
    there = servo(limited[rows], late)
    assert got[:, 1] == pytest.approx(there[:, 1], abs=1e-4)
    assert got[:, 0] == pytest.approx(there[:, 0], abs=5e-3)  # two steps say nothing of their pace


@pytest.mark.parametrize("hardest", [4.0, 12.0])
def test_speed_changes_no_faster_than_the_limit(hardest: float) -> None:
    stamp, setpoint = asked()
    got = servo(setpoint, stamp, acceleration_limit={"acceleration": hardest})
    for j in range(2):
        assert got[:, j] == pytest.approx(in_steps(setpoint[:, j], hardest=hardest), abs=2e-3)
    assert np.abs(np.diff(got, 2, axis=0)).max() * RATE**2 <= 1.0001 * hardest


def along_a_profile(setpoint: Array, ramp: float, top: float) -> Array:
    """Where a profile leads a joint to steps (n,) of which each is reached before the next: trapezoids."""
    at = np.flatnonzero(np.diff(setpoint, prepend=setpoint[0]))
    out = setpoint[0] + np.zeros((len(setpoint), round(1.0 / RATE / FINE)))
    since = (np.arange(out.size) * FINE).reshape(out.shape)
    for k in at:
        way = setpoint[k] - setpoint[k - 1]
        fastest = min(top, np.sqrt(abs(way) * ramp))
        whole, rises = abs(way) / fastest + fastest / ramp, fastest / ramp
        t = np.clip(since - k / RATE, 0.0, whole)
        rise, fall = np.minimum(t, rises), np.maximum(t - whole + rises, 0.0)
        out += np.sign(way) * (0.5 * ramp * rise**2 + fastest * (t - rise) - 0.5 * ramp * fall**2)
    return out


@pytest.mark.parametrize("fed", [0.0, 0.8])
@pytest.mark.parametrize(("ramp", "top"), [(2.0, np.inf), (2.0, 0.4), (30.0, 1.0)])
def test_a_profile_is_a_trapezoid_from_one_setpoint_to_the_next(ramp: float, top: float, fed: float) -> None:
    """What a drive tells its loop of speeds is that of its profile: a step has none."""
    stamp = np.arange(0.0, 6.0, 1.0 / RATE)
    setpoint = np.where(stamp > 0.5, 0.5, 0.0) - np.where(stamp > 3.0, 0.8, 0.0)
    led, phi, v, shaft = along_a_profile(setpoint, ramp, top), 0.0, 0.0, []
    paces = np.gradient(led.ravel(), FINE).reshape(led.shape)
    for row, pace in zip(led, paces, strict=True):
        shaft.append(phi)
        for target, speed in zip(row, pace, strict=True):
            v += (KP * (target - phi) + fed * speed - v) / TAU * FINE
            phi += v * FINE
    arm = replace(arm_of(1), kp=KP, tau_v=TAU, v_max=top, feedforward=fed, step=0.0)
    model = Model(arm, {"setpoint_profile": {"acceleration": ramp}})
    got = Chain(model, "servo").run(setpoint[:, None], stamp)[0]
    assert got[:, 0] == pytest.approx(shaft, abs=2e-4)


@pytest.mark.parametrize("columns", [1, 4])
@pytest.mark.parametrize("fed", [0.0, 0.8])
def test_a_run_that_begins_within_a_profile_goes_on_at_its_speed(fed: float, columns: int) -> None:
    """However far the setpoint is, for an integral part as well."""
    stamp = np.arange(0.0, 4.0, 1.0 / RATE)
    setpoint = np.repeat(np.where(stamp > 0.5, 1.5, 0.0)[:, None], columns, axis=1)
    arm = replace(arm_of(columns), kp=KP, tau_v=TAU, v_max=0.5, feedforward=fed)
    model = Model(arm, {"setpoint_profile": {"acceleration": 3.0}, "integral_action": {"ki": 8.0}})
    whole, cut = Chain(model, "servo").run(setpoint, stamp)[0], 200
    now, first = surroundings(stamp, columns), np.diff(whole, axis=0, prepend=whole[:1]) * RATE
    core = servo_core(arm, model.bound("servo"), now)
    now = replace(now, gearbox=whole, speed=first * now.ratio)
    again = run_servo(core, now, setpoint, stamp, fresh(whole[0]), [cut])[0]
    assert again[: cut + 1] == pytest.approx(whole[: cut + 1], abs=1e-9)
    assert again == pytest.approx(whole, abs=0.01)


def test_a_profile_that_is_quick_enough_follows_setpoints_that_move_as_if_there_were_none() -> None:
    stamp, setpoint = asked()
    smooth = setpoint[:, 1:]
    led = [servo(smooth, stamp, setpoint_profile={"acceleration": ramp}) for ramp in (20.0, 40.0, 1e4)]
    lags = [np.abs(one - servo(smooth, stamp)).max() for one in led]
    assert lags[2] < 6e-3 < lags[1] < lags[0]  # 27 mrad each 10 ms take 3.3


@pytest.mark.parametrize("friction", [2e-3, 0.02])
def test_dry_friction_holds_the_shaft_back(friction: float) -> None:
    """As far as it goes: at rest any error up to that stays, and in motion all of it is added to the lag."""
    stamp, setpoint = asked()
    got = servo(setpoint, stamp, motor_friction={"friction": friction})
    for j in range(2):
        assert got[:, j] == pytest.approx(in_steps(setpoint[:, j], dry=friction), abs=2e-3)
    ramp = 0.4 * stamp[:, None]
    lags = [ramp - servo(ramp, stamp, motor_friction={"friction": each}) for each in (friction, 0.0)]
    assert (lags[0] - lags[1])[200:] == pytest.approx(friction, rel=1e-3)
    stays = servo(0.9 * friction * (stamp[:, None] > 1.0), stamp, motor_friction={"friction": friction})
    assert np.array_equal(stays, 0.0 * stays)


@pytest.mark.parametrize("late", [0.01, 0.0137])
def test_setpoints_that_are_stamped_late_are_seen_before_their_stamps(late: float) -> None:
    stamp, setpoint = asked()
    arm = replace(arm_of(2), kp=KP, tau_v=TAU, v_max=50.0, step=0.0)
    model = Model(arm, {"servo_delay": {"delay": -late}})
    series = JointSeries(stamp + late, arm.joints, setpoint)
    there = servo_course(JointSeries(stamp, arm.joints, setpoint), stamp[50:-10], Model(arm)).position
    assert servo_course(series, stamp[50:-10], model).position == pytest.approx(there, abs=2e-5)


@pytest.mark.parametrize("begins", [0.60, 0.75, 1.0, 1.2])
def test_a_run_that_begins_within_a_profile_goes_on_along_it(begins: float) -> None:
    """While it gathers speed, at its top speed, and while it brakes: nobody recorded how far it is."""
    stamp = np.arange(0.0, 3.0, 1.0 / RATE)
    setpoint = np.where(stamp > 0.5, 0.5, 0.0)[:, None]
    arm = replace(arm_of(1), kp=KP, tau_v=TAU, v_max=0.9, step=0.0)
    blocks = Model(arm, {"setpoint_profile": {"acceleration": 2.5}}).bound("servo")
    whole = Chain(Model(arm, {"setpoint_profile": {"acceleration": 2.5}}), "servo").run(setpoint, stamp)[0]
    first = int(np.searchsorted(stamp, begins))
    now = replace(surroundings(stamp[first:], 1), gearbox=whole[first:])
    core, start = servo_core(arm, blocks, now), fresh(whole[first], np.gradient(whole[:, 0], stamp)[first])
    begun = with_profiles(core, now, setpoint[first:], start)
    off, plain = (
        np.abs(run_servo(core, now, setpoint[first:], now.stamp, one)[0] - whole[first:]).max()
        for one in (begun, start)
    )
    assert off < 1e-3
    assert off < 0.1 * plain or plain < 1e-3
