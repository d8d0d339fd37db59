"""Claims about noise that grows with speed: it is measured, and what moves fast counts less."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, recorded
from trunk_ros.compiled import Array
from trunk_ros.data.louder import IN_POWER, IN_SIZE, NONE, Growth, Louder, growth
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
    found = growth([_loud(k) + physics], [SPEED], [EVERY])
    assert found.rate == pytest.approx(k, rel=0.15)
    assert found.power == IN_POWER


@pytest.mark.parametrize(("share", "within"), [(0.1, 0.8), (0.3, 0.25), (1.0, 0.25)])
def test_growth_is_measured_of_a_joint_that_mostly_rests_and_of_noise_on_top_of_that_at_rest(
    share: float, within: float
) -> None:
    """In equal shares of all samples such a joint moved in one of them alone."""
    rng = np.random.default_rng(1)
    speed = np.where(np.arange(len(SPEED)) < share * len(SPEED), SPEED, 1e-5 * rng.random(len(SPEED)))
    noise = NOISE * (1.0 + 16.0 * np.abs(speed)) * rng.standard_normal(len(speed))
    found = growth([noise], [speed], [EVERY])
    assert found.rate == pytest.approx(16.0, rel=within)
    assert found.power == IN_SIZE or within > 0.5  # which of 600 samples do not tell


def test_steady_noise_does_not_grow() -> None:
    assert growth([_loud(0.0)], [SPEED], [EVERY]) == NONE


def test_what_rings_in_fast_motion_is_no_noise() -> None:
    ringing = 3e-3 * np.abs(SPEED) * np.sin(2 * np.pi * 9.0 * STAMP)
    assert growth([_loud(0.0) + ringing], [SPEED], [EVERY]) == NONE


def test_readings_that_stand_between_counts_at_some_speeds_tell_nothing_of_growth() -> None:
    speed = np.sort(np.abs(SPEED))  # stretches of one speed each, as jogs are
    slowest, silent = np.quantile(speed, [0.15, 0.5])
    seen = np.where(speed < slowest, 1e-4, np.where(speed < silent, 0.0, 1.0)) * _loud(15.0, speed)
    assert growth([seen], [speed], [EVERY]) == NONE


def test_sensors_are_alike_where_most_agree() -> None:
    some, more = Growth(10.0), Growth(12.0, IN_SIZE)
    assert Louder.of([some, NONE, more]).each == (some, more, more)
    assert Louder.of([some, NONE, NONE]).each == (some, NONE, NONE)
    assert Louder().at(SPEED, 0) == 1.0


def test_a_zero_is_no_noise_that_goes_with_the_speed() -> None:
    louder, noise, zero = Louder((Growth(15.0),)), _loud(15.0), np.full(len(SPEED), 0.3)
    even = louder.evened(noise + zero, SPEED, 0, zero=zero) - zero
    assert even == pytest.approx(louder.evened(noise, SPEED, 0))
    assert np.std(even) == pytest.approx(NOISE, rel=0.05)
    assert Louder().evened(noise, SPEED, 0, zero=zero) is noise


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
