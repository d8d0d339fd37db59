"""Claims about motors whose readings are repeated until the next ones come: each counts once, and where
motors rest, or go in steps, nothing is repeated.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from test.diagnosis.arms import NOISE, RATE, SHORT, diagnose, recorded
from trunk_ros.compiled import Array
from trunk_ros.data.align import servo_span, wire_span
from trunk_ros.data.put_right import as_diagnosed
from trunk_ros.data.repeated_readings import new_motor_readings
from trunk_ros.data.sensing import clocks_put_right
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate

EACH = 5  # readings that are one
TOLD = {"gearbox_states": "trunk/gearbox_states", "joint_states": "joint_states"}


@pytest.fixture(scope="module")
def clean() -> Recording:
    """A clean arm whose motors all rest for some seconds in between."""
    return _resting(recorded(seconds=30.0, nominal=SHORT, size=2.0, noise=0.0))


def _resting(recording: Recording) -> Recording:
    """The recording slowed down to a rest from 12 to 16 s, with noise on joints: a play knows no time."""
    series = {}
    for key in TOLD:
        one = recording.series[key]
        pace = np.clip(np.abs(one.stamp - 14.0) - 2.0, 0.0, 1.0)
        at = np.cumsum(pace * pace * (3.0 - 2.0 * pace)) / RATE
        position = CubicSpline(one.stamp, one.position)(at)
        if key == "joint_states":
            position += np.random.default_rng(4).normal(0.0, NOISE, position.shape)
        series[key] = replace(one, position=position, velocity=None, effort=None)
    return replace(recording, series=series)


def _held(recording: Recording, *keys: str) -> Recording:
    """The recording with only each fifth reading of some topics, repeated until the next one."""
    series = dict(recording.series)
    for key in keys:
        one = series[key]
        series[key] = replace(one, position=one.position[_new(len(one.stamp))])
    return replace(recording, series=series)


def _new(count: int) -> Array:
    return np.arange(count) // EACH * EACH


def test_motors_that_repeat_their_readings_are_no_mismatch_and_it_is_said(clean: Recording) -> None:
    """They had been a link that rings, on every joint, and a clock that is early."""
    held = _held(clean, "gearbox_states")
    right = clocks_put_right(held, SHORT)
    assert [(one.kind, one.topic) for one in right.observed] == [("repeats", TOLD["gearbox_states"])]
    assert right.observed[0].value == pytest.approx(EACH / RATE)
    found = diagnose([held], SHORT)
    assert (found.verdict, found.findings) == ("no_mismatch", [])


def test_of_repeats_it_is_said_what_they_look_like_in_what_the_recording_shows() -> None:
    """Where no joints were recorded, old readings of motors are no joints that are early."""
    held = _held(recorded(seconds=30.0, nominal=SHORT, size=2.0), "gearbox_states")
    servos = replace(held, series={k: v for k, v in held.series.items() if k != "joint_states"})
    wires = replace(held, series={k: v for k, v in held.series.items() if k != "setpoints"})
    both, servo, wire = (clocks_put_right(one, SHORT).observed[0] for one in (held, servos, wires))
    assert servo.looks_like == ("servo_delay",)
    assert "shows as a delay of the servos. It would have looked like servo_delay" in servo.statement
    assert "shows as joints that are early. " in wire.statement
    assert "servo_delay" not in wire.looks_like
    assert {*both.looks_like} == {*servo.looks_like, *wire.looks_like}


def test_both_topics_may_repeat_their_readings(clean: Recording) -> None:
    right = clocks_put_right(_held(clean, "gearbox_states", "joint_states"), SHORT)
    assert {one.topic for one in right.observed} == set(TOLD.values())


def test_a_motor_that_rests_repeats_nothing(clean: Recording) -> None:
    motors, shown = clean.series["gearbox_states"], clean.series["joint_states"]
    assert new_motor_readings(motors, shown) == (motors, 0.0)
    new, period = new_motor_readings(_held(clean, "gearbox_states").series["gearbox_states"], shown)
    assert period == pytest.approx(EACH / RATE)
    rest = new.stamp[(new.stamp > 12.0) & (new.stamp < 16.0)]
    assert np.diff(rest).max() <= 2.0 * period + 1.0 / RATE  # that it stands is a fact as well


@pytest.mark.parametrize("late", [0, 2])
def test_motors_that_go_in_steps_take_their_joints_with_them(clean: Recording, late: int) -> None:
    held = _held(clean, "gearbox_states").series["gearbox_states"]
    shown = clean.series["joint_states"]
    follows = replace(shown, position=np.roll(SHORT.arm.ratio * held.position, late, axis=0))
    assert new_motor_readings(held, follows) == (held, 0.0)


def test_spans_and_simulate_read_what_is_diagnosed(clean: Recording) -> None:
    held = _held(clean, "gearbox_states")
    right = as_diagnosed(held, SHORT)
    raw, put_right = (wire_span(one, SHORT) for one in (held, right))
    np.testing.assert_allclose(raw.gearbox, put_right.gearbox, atol=1e-9)
    raw, put_right, steady = (simulate(one, SHORT).series["joint_states"] for one in (held, right, clean))
    np.testing.assert_allclose(raw.position, put_right.position, atol=1e-9)
    assert np.sqrt(np.mean((raw.position - steady.position) ** 2)) < 2e-4


def test_of_a_servos_readings_each_counts_once() -> None:
    whole = recorded(seconds=30.0, nominal=SHORT, size=2.0)
    seen = servo_span(_held(whole, "gearbox_states"), SHORT)
    there = servo_span(whole, SHORT)
    assert len(seen.target) == pytest.approx(len(there.target) / EACH, rel=0.05)
    at = np.interp(seen.stamp, there.stamp, there.target[:, 0])
    np.testing.assert_allclose(seen.target[seen.valid[:, 0], 0], at[seen.valid[:, 0]], atol=1e-4)
