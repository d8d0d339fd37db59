"""Wide loops, motions at one pace, and sensors that hold or step."""

from __future__ import annotations

import numpy as np

from trunk_ros.data.motion_content import comes_back, is_wide, repeats, speed_tells, turned
from trunk_ros.data.repeated_readings import coarseness, new_readings
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.recording.recording import JointSeries

T = np.arange(0.0, 20.0, 0.005)
SWING, SPEED = np.sin(T), np.cos(T)


def played(half_width: float) -> np.ndarray:
    return SharpPlay().run(SWING[:, None], np.array([[half_width]]), None)[0][:, 0] - SWING


def held(period: float) -> JointSeries:
    reading = np.sin(np.floor(T / period) * period)
    return JointSeries(T, ("a",), reading[:, None])


def test_a_play_of_a_third_of_the_motion_is_a_wide_loop_and_one_of_a_hundredth_is_not() -> None:
    assert is_wide(SWING, played(0.3), SWING + played(0.3))
    assert not is_wide(SWING, played(0.01), SWING + played(0.01))


def test_a_loop_is_as_wide_of_a_drive_whose_ratio_nobody_knew() -> None:
    """Volts for micrometres: a loop of a third of what the stack moves is one of a hundredth of the volts."""
    for half_width, wide in ((0.3, True), (0.01, False)):
        shown = SWING + played(half_width)
        assert is_wide(30.0 * SWING, shown - 30.0 * SWING, shown) == wide


def test_a_motor_that_trembles_while_its_joint_creeps_is_no_wide_loop_and_hides_nothing() -> None:
    """A muscle under a pressure that steps, overshoots and holds: psi for mm, the ratio is far off."""
    noise = np.random.default_rng(3).normal(0.0, 0.2, T.shape)
    pressure = np.interp(T, [0.0, 2.0, 2.2, 2.4], [0.0, 0.0, 250.0, 240.0]) + noise
    shown = 0.04 * pressure + 5.0 * (1.0 - np.exp(-np.maximum(T - 2.4, 0.0) / 5.0))
    assert not is_wide(pressure, shown - pressure, shown)


def test_who_has_gone_as_far_as_ever_lies_at_one_side_of_a_play_before_he_turns() -> None:
    rises = np.interp(T, [0.0, 5.0, 15.0, 20.0], [0.0, 1.0, 1.0, 0.0])
    assert turned(rises).tolist() == (T[np.argmax(rises >= 0.9)] <= T).tolist()


def test_a_swing_at_one_pace_tells_nothing_of_speed_and_one_at_two_paces_does() -> None:
    assert not speed_tells([SWING], [SPEED])
    faster = np.where(T < 10.0, T, 3.0 * (T - 10.0) + 10.0)
    assert speed_tells([np.sin(faster)], [np.gradient(np.sin(faster), T)])


def test_nor_do_swings_of_several_sizes_at_one_pace_and_those_at_two_do_in_several_recordings() -> None:
    """Where a joint turned tells a loop as much as its speed does."""
    larger = 0.2 + 1.5 * np.sin(T + 1.0)
    assert not speed_tells([SWING, larger], [SPEED, 1.5 * np.cos(T + 1.0)])
    for size in (1.0, 1.5):
        assert speed_tells([SWING, size * np.sin(3.0 * T)], [SPEED, 3.0 * size * np.cos(3.0 * T)])


def test_a_recording_in_which_a_joint_stands_is_no_small_motion() -> None:
    trembles = 1e-3 * np.sin(40.0 * T)
    few = trembles[:400], np.gradient(trembles, T)[:400]
    assert not speed_tells([SWING, few[0]], [SPEED, few[1]])


def test_moves_with_rests_tell_something_of_speed() -> None:
    rested = np.sin(np.clip(T, 0.0, 10.0))
    assert speed_tells([rested], [np.gradient(rested, T)])


def test_a_swing_repeats_itself_once_it_has_seen_both_ends() -> None:
    cycles = T / (2.0 * np.pi)
    assert repeats(SWING, SPEED)
    for first in (1.0, 1.4):
        assert not repeats(SWING[cycles < first], SPEED[cycles < first])
    assert not repeats(np.ones(5), np.zeros(5))


def test_a_push_does_not_come_back_and_a_swing_does() -> None:
    assert comes_back(SWING)
    assert not comes_back(T)


def test_a_joint_has_turned_when_it_has_come_some_way_back() -> None:
    assert not turned(SWING)[np.pi / 2 > T].any()
    assert turned(SWING)[T > 2.5].all()


def test_of_held_readings_each_counts_once() -> None:
    fresh, period = new_readings(held(0.025))
    assert abs(period - 0.025) < 1e-6
    assert abs(len(fresh.stamp) - 800) < 20


def test_readings_that_are_all_new_or_steps_of_a_coarse_sensor_are_kept() -> None:
    fine = JointSeries(T, ("a",), SWING[:, None])
    coarse = JointSeries(T, ("a",), np.round(SWING, 1)[:, None])
    for series in (fine, coarse):
        assert new_readings(series) == (series, 0.0)


def test_a_coarse_sensor_adds_the_noise_of_its_steps() -> None:
    everything = np.ones(len(T), dtype=bool)
    assert abs(coarseness(np.round(SWING, 2), everything) - 0.01 / np.sqrt(12.0)) < 1e-6
    assert coarseness(SWING, everything) == 0.0
