"""Missing values: on the way between the known ones, or held as a servo holds what it was asked for."""

import numpy as np

from trunk_ros.recording.signal.fill import between, fill, hold

NAN = np.nan
SEEN = np.array([[NAN, 1.0], [2.0, NAN], [NAN, NAN], [4.0, 7.0], [NAN, NAN]])


def test_a_motion_goes_on_between_the_known_values():
    np.testing.assert_allclose(fill(SEEN), [[2, 1], [2, 3], [3, 5], [4, 7], [4, 7]])


def test_a_setpoint_holds_until_the_next_and_knows_nothing_of_it():
    np.testing.assert_allclose(hold(SEEN), [[2, 1], [2, 1], [2, 1], [4, 7], [4, 7]])


def test_values_that_are_never_known_are_zero():
    assert not hold(np.full((3, 2), NAN)).any()


def test_of_two_values_at_one_time_the_last_counts():
    stamp, values = np.array([0.0, 1.0, 1.0, 2.0]), np.array([[0.0], [9.0], [1.0], [2.0]])
    fine, held = between(stamp, values, 0.5)
    np.testing.assert_allclose(fine, [0.0, 0.5, 1.0, 1.5, 2.0])
    np.testing.assert_allclose(held[:4, 0], [0.25, 0.75, 1.25, 1.75])
