"""Claims about clocks that are off by a constant, or set in mid-run: they are told from physics, put right,
and said.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, on, recorded, reshaped
from trunk_ros.data.sensing import clocks_put_right
from trunk_ros.data.sensing.offset import Offset
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

EVERY = np.ones(5)
WORN = {
    "load_elasticity": {"compliance": 0.01 * EVERY}, "ratio_error": {"relative": on(1, 0.01)},
    "viscoelastic_creep": {"gain": on(3, 0.02), "time_constant": 2.0 * EVERY},
    "backlash": {"half_width": on(2, 2e-3)},
}  # fmt: skip


@pytest.fixture(scope="module")
def model() -> Model:
    """The nominal one."""
    return load_model("trunk")


@pytest.fixture(scope="module", params=[{}, WORN], ids=["clean", "worn"])
def arm(request: pytest.FixtureRequest) -> Recording:
    """A recording whose joints are read between the gearbox's readings."""
    made = recorded(request.param, 40.0)
    return reshaped(made, "gearbox_states", stamp=made.series["gearbox_states"].stamp + 1e-9)


def _off(recording: Recording, key: str, size: float, since: float = -1.0) -> Recording:
    """With one topic's clock ahead by ``size`` s from ``since`` s on."""
    stamp = recording.series[key].stamp
    return reshaped(recording, key, stamp=stamp + size * (stamp >= since))


def _right(recording: Recording, model: Model) -> tuple[Recording, list[str]]:
    out = clocks_put_right(recording, model)
    return out, [one.kind for one in out.observed]


@pytest.mark.parametrize("size", [3e-3, 12e-3])
def test_readings_ahead_of_the_motor_have_an_early_clock(arm: Recording, model: Model, size: float) -> None:
    right, kinds = _right(_off(arm, "joint_states", -size), model)
    assert kinds == ["early"]
    assert right.observed[0].value == pytest.approx(size, abs=1.5e-4)
    off = right.series["joint_states"].stamp - arm.series["joint_states"].stamp
    assert np.abs(off).max() < 1.5e-4


@pytest.mark.parametrize("forces", [lambda v: 0.3 * v, lambda v: np.tanh(v / 0.05)], ids=["viscous", "dry"])
def test_what_goes_by_the_speed_of_a_slow_swing_has_no_clock_that_is_seconds_early(
    forces: Callable[[np.ndarray], np.ndarray],
) -> None:
    stamp = np.arange(0.0, 40.0, 0.01)
    motor = 0.6 * np.sin(np.pi * stamp)
    noise = 1e-4 * np.random.default_rng(0).standard_normal(len(stamp))
    made = Recording.from_arrays(stamp, motor=motor, joint=forces(np.gradient(motor, stamp)) + noise)
    assert "early" not in _right(made, load_model("direct"))[1]


def test_a_joint_that_physics_makes_late_does_not_hide_an_early_clock(model: Model) -> None:
    late = recorded({"viscous_lag": {"time_constant": on(2, 0.03)}, "sensor_delay": {"delay": 0.002}})
    right, kinds = _right(_off(late, "joint_states", -7e-3), model)
    assert kinds == ["early"]
    assert right.observed[0].value == pytest.approx(5e-3, abs=1.5e-4)


@pytest.mark.parametrize(
    "effects",
    [
        WORN,
        {"sensor_delay": {"delay": 0.02}},
        {"sensor_delay": {"delay": 0.02, "from": 17.0}},
        {"sensor_delay": {"delay": 0.01, "until": 23.0}},
        {"viscous_lag": {"time_constant": 0.02 * EVERY}},
        {"viscoelastic_creep": {"gain": 0.1 * EVERY, "time_constant": 3.0 * EVERY}},
        {"viscoelastic_creep": {"gain": 0.1 * EVERY, "time_constant": 0.5 * EVERY}},
        {"stribeck_friction": {"amplitude": 4e-3 * EVERY, "velocity": 0.1 * EVERY}},
        {"stribeck_friction": {"amplitude": 1e-3 * EVERY, "velocity": 1.0 * EVERY}},
        {"servo_delay": {"delay": 0.03}, "servo_bandwidth": {"relative": 0.7}},
    ],
)
def test_what_physics_and_old_readings_do_is_no_clock_that_is_early_or_was_set(
    model: Model, effects: dict[str, dict[str, Any]]
) -> None:
    recording = recorded(effects, 40.0)
    assert _right(recording, model)[1] == []
    assert _right(_off(recording, "joint_states", 4e-3), model)[1] == []


@pytest.mark.parametrize("times", [-1.0, 0.3, -2.5])
def test_a_lag_is_no_lead_where_motors_turn_joints_the_other_way_or_by_another_gear(
    model: Model, times: float
) -> None:
    late = recorded({"sensor_delay": {"delay": 0.02}}, 40.0)
    turned = replace(late.series["gearbox_states"], position=late.series["gearbox_states"].position * times)
    if turned.velocity is not None:
        turned = replace(turned, velocity=turned.velocity * times)
    recording = replace(late, series={**late.series, "gearbox_states": turned})
    assert _right(recording, model)[1] == []
    right, kinds = _right(_off(recording, "joint_states", -0.025), model)
    assert kinds == ["early"]
    assert right.observed[0].value == pytest.approx(5e-3, abs=3e-4)


@pytest.mark.parametrize(
    ("key", "size"), [("joint_states", 4e-3), ("joint_states", -4e-3), ("gearbox_states", 20e-3)]
)
def test_a_clock_that_is_set_in_mid_run_is_set_back(
    arm: Recording, model: Model, key: str, size: float
) -> None:
    right, kinds = _right(_off(arm, key, size, since=18.0), model)
    assert kinds == ["clock_step"]
    (seen,) = right.observed
    assert seen.value == pytest.approx(size, abs=1e-4)
    assert seen.topic.endswith(key)
    assert np.abs(right.series[key].stamp - arm.series[key].stamp).max() < 1e-4


def test_all_topics_of_a_clock_are_set_back_with_it(arm: Recording, model: Model) -> None:
    both = _off(_off(arm, "gearbox_states", 0.01, since=18.0), "setpoints", 0.01, since=18.0)
    right, kinds = _right(both, model)
    assert kinds == ["clock_step"]
    for key, series in arm.series.items():
        np.testing.assert_allclose(right.series[key].stamp, series.stamp, atol=1e-4)


def test_what_would_come_before_earlier_samples_is_left_out() -> None:
    series = JointSeries(np.arange(5.0), ("a",), np.arange(5.0)[:, None])
    back = Offset(1.5, 0.1, since=2.0).off(series)
    assert back.stamp.tolist() == [0.0, 1.0, 1.5, 2.5]
    assert back.position[:, 0].tolist() == [0.0, 1.0, 3.0, 4.0]


def test_what_is_left_of_an_early_clock_is_found_with_the_physics() -> None:
    loose = recorded({"backlash": {"half_width": on(3, 2e-3)}}, seed=3)
    found = diagnose(_off(loose, "joint_states", -4e-3))
    assert found.verdict == "explained"
    assert len(found.findings) == 1
    assert "backlash" in found.findings[0].candidates


@pytest.mark.parametrize("seed", range(3))
def test_what_is_said_of_a_clock_that_was_set_is_done(model: Model, seed: int) -> None:
    """Also where stamps are as uneven as the step is large."""
    made, rng = recorded({}, 40.0), np.random.default_rng(seed)
    even = made.series["joint_states"].stamp
    late = np.maximum.accumulate(np.sort(even + 2e-3 * rng.normal(size=len(even))) + 2.2e-3 * (even >= 18.0))
    made = reshaped(made, "gearbox_states", stamp=even + 1e-9)
    right, kinds = _right(reshaped(made, "joint_states", stamp=late + 1e-9 * np.arange(len(even))), model)
    moved = right.series["joint_states"].stamp[-1] - late[-1]
    said = sum(one.value for one in right.observed if one.kind == "clock_step")
    assert moved == pytest.approx(-said, abs=5e-4)  # the stamps themselves tell it better than the lag
    assert kinds.count("clock_step") <= 1
