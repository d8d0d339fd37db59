"""The meaning that joint_trajectory_controller gives to trajectories."""

import numpy as np
import pytest

from trunk_ros.nodes.control.follower import Follower, state_at
from trunk_ros.trajectory import Limits, Trajectory, TrajectoryError

JOINTS = ("a", "b")
WHOLE = np.ones(2)
LIMITS = Limits(-WHOLE, WHOLE, 10 * WHOLE, 1e3 * WHOLE)


def follower(position=(0.0, 0.0)):
    return Follower(JOINTS, LIMITS, np.array(position))


def to(*positions, time=1.0, joints=JOINTS):
    return Trajectory(joints, np.array([time]), np.array([positions]))


def test_it_goes_from_where_it_is_and_holds_the_last_point():
    it = follower()
    it.follow(to(0.4, -0.2), now=10.0)
    np.testing.assert_allclose(it.sample(10.5)[0], [0.2, -0.1])
    np.testing.assert_allclose(it.sample(99.0)[0], [0.4, -0.2])
    np.testing.assert_array_equal(it.sample(99.0)[1], 0.0)


def test_a_joint_that_is_not_named_stays():
    it = follower((0.1, 0.2))
    it.follow(to(0.4, joints=("b",)), now=0.0)
    np.testing.assert_allclose(it.sample(2.0)[0], [0.1, 0.4])


def test_a_trajectory_replaces_the_one_under_way_without_a_jump():
    it = follower()
    it.follow(to(0.4, 0.0), now=0.0)
    before = it.sample(0.5)[0]
    it.follow(to(0.0, 0.3), now=0.5)
    np.testing.assert_allclose(it.sample(0.5)[0], before)
    np.testing.assert_allclose(it.sample(1.5)[0], [0.0, 0.3])


def test_stopping_holds_where_the_reference_is():
    it = follower()
    it.follow(to(0.4, 0.0), now=0.0)
    it.stop(0.25)
    np.testing.assert_allclose(it.sample(3.0)[0], [0.1, 0.0])


def test_points_of_the_past_are_left_out():
    it = follower()
    path = Trajectory(JOINTS, np.array([1.0, 3.0]), np.array([[0.9, 0.0], [0.5, 0.0]]))
    it.follow(path, now=2.0, begin=0.0)
    np.testing.assert_allclose(it.sample(2.5)[0], [0.25, 0.0])
    with pytest.raises(TrajectoryError, match=r"last point was due 7.000 s ago"):
        it.follow(path, now=10.0, begin=0.0)


def test_a_refused_trajectory_leaves_the_one_under_way():
    it = follower()
    it.follow(to(0.4, 0.0), now=0.0)
    with pytest.raises(TrajectoryError, match="b would reach"):
        it.follow(to(0.0, 1.5), now=0.5)
    np.testing.assert_allclose(it.sample(1.0)[0], [0.4, 0.0])


def test_a_first_point_that_is_due_at_once_has_to_be_near():
    it = follower()
    it.follow(to(0.01, 0.0, time=0.0), now=0.0)
    with pytest.raises(TrajectoryError, match="due at once but elsewhere"):
        it.follow(to(0.5, 0.0, time=0.0), now=0.0)


def test_one_time_gives_what_many_times_give():
    rng = np.random.default_rng(4)
    at = np.array([-0.1, 0.0, 0.3, 1.0, 1.7, 2.0, 2.5])
    for derivatives in (0, 1, 2):
        points = rng.normal(size=(1 + derivatives, 3, 2))
        path = Trajectory(JOINTS, np.array([0.0, 1.0, 2.0]), *points)
        one_by_one = [np.array(each) for each in zip(*(state_at(path, time) for time in at), strict=True)]
        np.testing.assert_allclose(one_by_one, path.sample(at), atol=1e-12)


def test_a_trajectory_that_does_not_end_at_rest_is_refused():
    moving = Trajectory(JOINTS, np.array([1.0]), np.array([[0.4, 0.0]]), np.array([[0.0, 0.1]]))
    with pytest.raises(TrajectoryError, match=r"b would still move at 0.1 rad/s at the last point"):
        follower().follow(moving, now=0.0)
