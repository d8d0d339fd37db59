"""Missing values: on the way between the known ones, or held as a servo holds what it was asked for."""

import numpy as np

from trunk_ros.recording.signal.fill import fill, hold

NAN = np.nan
SEEN = np.array([[NAN, 1.0], [2.0, NAN], [NAN, NAN], [4.0, 7.0], [NAN, NAN]])


def test_a_motion_goes_on_between_the_known_values():
    np.testing.assert_allclose(fill(SEEN), [[2, 1], [2, 3], [3, 5], [4, 7], [4, 7]])


def test_a_setpoint_holds_until_the_next_and_knows_nothing_of_it():
    np.testing.assert_allclose(hold(SEEN), [[2, 1], [2, 1], [2, 1], [4, 7], [4, 7]])


def test_values_that_are_never_known_are_zero():
    assert not hold(np.full((3, 2), NAN)).any()
