"""Claims about noise that grows with speed: it is measured, and what moves fast counts less."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, recorded
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.louder import Louder, growth
from trunk_ros.recording.recording import Recording

RNG = np.random.default_rng(11)
STAMP = np.arange(6000) * 0.01
SPEED = 0.4 * np.sin(2 * np.pi * 0.13 * STAMP) * np.sin(2 * np.pi * 0.011 * STAMP)
EVERY = np.ones(len(STAMP), dtype=bool)
NOISE = 1e-4


def _loud(k: float, speed: Array = SPEED) -> Array:
    return np.asarray(NOISE * np.hypot(1.0, k * speed) * RNG.standard_normal(len(speed)))


@pytest.mark.parametrize("k", [6.0, 15.0])
def test_growth_with_speed_is_measured_beside_smooth_physics(k: float) -> None:
    physics = 3e-3 * np.sin(2 * np.pi * 0.3 * STAMP)
    assert growth([_loud(k) + physics], [SPEED], [EVERY]) == pytest.approx(k, rel=0.15)


def test_steady_noise_does_not_grow() -> None:
    assert growth([_loud(0.0)], [SPEED], [EVERY]) == 0.0


def test_what_rings_in_fast_motion_is_no_noise() -> None:
    ringing = 3e-3 * np.abs(SPEED) * np.sin(2 * np.pi * 9.0 * STAMP)
    assert growth([_loud(0.0) + ringing], [SPEED], [EVERY]) == 0.0


def test_readings_that_stand_between_counts_at_some_speeds_tell_nothing_of_growth() -> None:
    speed = np.sort(np.abs(SPEED))  # stretches of one speed each, as jogs are
    slowest, silent = np.quantile(speed, [0.15, 0.5])
    seen = np.where(speed < slowest, 1e-4, np.where(speed < silent, 0.0, 1.0)) * _loud(15.0, speed)
    assert growth([seen], [speed], [EVERY]) == 0.0


def test_sensors_are_alike_where_most_agree() -> None:
    assert Louder.of([10.0, 0.0, 12.0]).each == (10.0, 11.0, 12.0)
    assert Louder.of([10.0, 0.0, 0.0]).each == (10.0, 0.0, 0.0)
    assert Louder().at(SPEED, 0) == 1.0


def test_a_clean_arm_whose_readings_jitter_is_clean() -> None:
    steady = recorded({}, seconds=40.0, noise=0.0)
    jitter = _jittering(steady, 2e-3)
    found = diagnose([jitter])
    assert found.findings == []
    floor = [joint["noise_floor"] for joint in found.stages["wire"]["joints"].values()]
    assert max(floor) < 2.0 * NOISE  # that at rest


def _jittering(recording: Recording, blur: float) -> Recording:
    """Readings with noise that is ``blur`` rad at 1 rad/s."""
    shown = recording.series["joint_states"]
    speed = np.gradient(shown.position, shown.stamp, axis=0)
    noise = np.hypot(NOISE, blur * speed) * np.random.default_rng(5).standard_normal(speed.shape)
    series = {**recording.series, "joint_states": replace(shown, position=shown.position + noise)}
    return replace(recording, series=series)
