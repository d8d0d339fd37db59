"""Between its readings a shaft goes as they do: it does not swing past the place where it stops."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from test.diagnosis.arms import diagnose
from test.effects.example import arm_of
from trunk_ros.compiled import Array
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.resample import resample
from trunk_ros.recording.signal.through_readings import slopes
from trunk_ros.recording.staggered import at_stamps

FINE = np.arange(0.0, 40.0, 1e-3)
BAND = 1.5e-3  # rad
ARM = Model(
    replace(
        arm_of(1, dead_band=BAND), joints=("reel",), ratio=np.ones(1), lower=-np.ones(1), upper=np.ones(1)
    )
)


def _abrupt(rng: np.random.Generator) -> Array:
    """A shaft that goes at a steady speed from place to place, and stands between."""
    at = np.cumsum(rng.uniform(0.4, 1.6, 80))
    return np.interp(FINE, at, np.repeat(rng.uniform(-1.0, 1.0, 40), 2))


def _series(rate: float, way: Array, late: float = 0.0) -> JointSeries:
    t = np.arange(late, 39.9, 1.0 / rate)
    return JointSeries(t, ("reel",), np.interp(t, FINE, way)[:, None])


@pytest.mark.parametrize("rate", [10.0, 50.0, 250.0])
def test_a_shaft_that_stops_is_not_taken_past_that_place(rate: float) -> None:
    way = _abrupt(np.random.default_rng(3))
    read = _series(rate, way)
    inside = read.stamp[-1] > FINE
    curve = resample(read, FINE[inside])[0][:, 0]
    before = np.clip(np.searchsorted(read.stamp, FINE[inside], side="right") - 1, 0, len(read.stamp) - 2)
    ends = np.sort([read.position[before, 0], read.position[before + 1, 0]], axis=0)
    stands = ends[1] - ends[0] < 1e-9
    spline = CubicSpline(read.stamp, read.position[:, 0])(FINE[inside])
    assert np.abs(spline - ends[0])[stands].max() > 2e-4
    assert np.abs(curve - ends[0])[stands].max() < 1e-6
    assert max((ends[0] - curve).max(), (curve - ends[1]).max()) < 1e-6


def test_a_measured_velocity_that_is_late_does_not_take_it_there_either() -> None:
    read = _series(100.0, _abrupt(np.random.default_rng(3)))
    late = np.gradient(read.position[:, 0], read.stamp)[np.maximum(np.arange(len(read.stamp)) - 1, 0)]
    inside = FINE[read.stamp[-1] > FINE]
    curve = resample(replace(read, velocity=late[:, None]), inside)[0]
    swung = np.ptp(curve) - np.ptp(read.position)
    assert swung < 1e-6


def test_nor_do_motors_with_a_topic_each_that_are_brought_to_one_time() -> None:
    read = _series(50.0, _abrupt(np.random.default_rng(3)))
    own, there = read.position[:, 0], read.stamp[:-1] + 0.007
    swung = [
        np.ptp(at_stamps(there, read.stamp, own, False, driving)) - np.ptp(own) for driving in (True, False)
    ]
    assert swung[0] < 1e-6
    assert swung[1] > 1e-3


@pytest.mark.parametrize("rate", [20.0, 100.0])
def test_a_smooth_way_and_its_turns_are_those_of_the_spline(rate: float) -> None:
    way = 0.7 * np.sin(1.9 * FINE) + 0.3 * np.sin(3.1 * FINE + 1.0)
    read = _series(rate, way)
    inside = read.stamp[-1] - 0.2 > FINE
    spline = CubicSpline(read.stamp, read.position[:, 0])(FINE[inside])
    assert np.abs(resample(read, FINE[inside])[0][:, 0] - spline).max() < 5e-5


@pytest.mark.parametrize("turn", [0.03, 39.85])
def test_nor_does_it_swing_or_flatten_a_turn_in_its_first_and_last_step(turn: float) -> None:
    read = _series(20.0, 0.5 - 0.5 * np.cos(1.9 * (FINE - turn)))
    inside = read.stamp[-1] > FINE
    off = resample(read, FINE[inside])[0][:, 0] - (0.5 - 0.5 * np.cos(1.9 * (FINE[inside] - turn)))
    assert np.abs(off).max() < 1e-5
    stands = np.array([0.0, 0.0, 0.1, 0.2, 0.3, 0.4, 0.4])
    np.testing.assert_array_equal(slopes(np.arange(7.0), stands, None)[[0, 1, 5, 6]], 0.0)


@pytest.mark.parametrize("rate", [10.0, 100.0])
def test_a_clean_arm_that_stops_abruptly_is_clean(rate: float) -> None:
    rng = np.random.default_rng(5)
    way = _abrupt(rng)
    read = {"gearbox_states": _series(rate, way), "joint_states": JointSeries(*_played(way, rate, rng))}
    recording = Recording("abrupt", 0, 40.0, read)
    assert not diagnose(recording, ARM).findings


def _played(way: Array, rate: float, rng: np.random.Generator) -> tuple[Array, tuple[str, ...], Array]:
    """Readings of the joint, half a period later than those of its motor."""
    moved = SharpPlay().run(way[:, None], np.full((1, 1), BAND), None)[0]
    late = _series(rate, moved[:, 0], 0.5 / rate)
    return late.stamp, late.joints, late.position + rng.normal(0.0, 1e-4, late.position.shape)
