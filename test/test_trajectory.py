"""Trajectories: sampling, limits, files."""

import numpy as np
import pytest

from trunk_ros.trajectory import Limits, Trajectory, TrajectoryError, load_trajectory, save_trajectory

JOINTS = ("a", "b")


def limits(reach=1.0, speed=10.0, acceleration=1e3):
    whole = np.ones(2)
    return Limits(-reach * whole, reach * whole, speed * whole, acceleration * whole)


def random_trajectory(derivatives):
    rng = np.random.default_rng(4)
    time = np.cumsum(rng.uniform(0.2, 1.0, 6))
    return Trajectory(JOINTS, time, *(rng.normal(size=(6, 2)) for _ in range(1 + derivatives)))


@pytest.mark.parametrize("derivatives", [0, 1, 2])
def test_it_passes_through_its_points_with_their_derivatives(derivatives):
    trajectory = random_trajectory(derivatives)
    given = [trajectory.position, trajectory.velocity, trajectory.acceleration]
    for sampled, wanted in zip(
        trajectory.sample(trajectory.time[:-1]), given[: derivatives + 1], strict=False
    ):
        np.testing.assert_allclose(sampled, wanted[:-1], atol=1e-9)


@pytest.mark.parametrize("derivatives", [1, 2])
def test_velocity_is_the_slope_of_position(derivatives):
    trajectory, step = random_trajectory(derivatives), 1e-5
    at = np.linspace(trajectory.time[0] + 0.01, trajectory.time[-1] - 0.01, 40)
    slope = (trajectory.sample(at + step)[0] - trajectory.sample(at - step)[0]) / (2 * step)
    np.testing.assert_allclose(slope, trajectory.sample(at)[1], atol=1e-5)


def test_it_rests_at_its_ends():
    trajectory = random_trajectory(1)
    position, velocity, _ = trajectory.sample([-1.0, trajectory.duration + 1.0])
    np.testing.assert_array_equal(position, trajectory.position[[0, -1]])
    np.testing.assert_array_equal(velocity, 0.0)


def test_positions_alone_are_joined_by_straight_lines():
    trajectory = Trajectory(JOINTS, np.array([0.0, 2.0]), np.array([[0.0, 0.0], [1.0, -2.0]]))
    np.testing.assert_allclose(trajectory.sample(0.5)[0][0], [0.25, -0.5])


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        ({"reach": 0.9}, "a would reach"),
        ({"speed": 0.5}, "a would move at"),
        ({"acceleration": 1.0}, "a would accelerate at"),
    ],
)
def test_the_limit_that_would_be_broken_is_named(limit, words):
    still = np.zeros((2, 2))
    trajectory = Trajectory(JOINTS, np.array([0.0, 2.0]), np.array([[0.0, 0.0], [1.0, 0.0]]), still, still)
    trajectory.check(limits())
    with pytest.raises(TrajectoryError, match=words):
        trajectory.check(limits(**limit))


def test_a_limit_that_is_broken_between_points_is_found():
    trajectory = Trajectory(
        JOINTS, np.array([0.0, 1.0]), np.zeros((2, 2)), np.array([[8.0, 0.0], [-8.0, 0.0]])
    )
    with pytest.raises(TrajectoryError, match="a would reach"):
        trajectory.check(limits())


def test_a_start_beyond_the_limits_may_come_back():
    trajectory = Trajectory(JOINTS, np.array([0.0, 2.0]), np.array([[1.2, 0.0], [0.5, 0.0]]))
    trajectory.check(limits())


def test_joints_that_are_left_out_stay_where_they_are():
    whole = Trajectory(("b",), np.array([1.0]), np.array([[0.3]])).for_joints(JOINTS, np.array([0.7, 0.0]))
    np.testing.assert_array_equal(whole.position, [[0.7, 0.3]])
    with pytest.raises(TrajectoryError, match="unknown joint 'b': the arm has c"):
        Trajectory(("b",), np.array([1.0]), np.array([[0.3]])).for_joints(("c",), np.zeros(1))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("[", "is not YAML"),
        ("3", "joint_names and points"),
        ("{joint_names: [a], points: [{time_from_start: 1}]}", "lacks positions"),
        ("{joint_names: [a], points: [{positions: [x], time_from_start: 1}]}", "not a set of numbers"),
        ("{joint_names: [a], points: [{positions: [1, 2], time_from_start: 1}]}", "one position for each"),
        ("{joint_names: [a], points: [{positions: [.nan], time_from_start: 1}]}", "not finite"),
        ("{joint_names: [a], points: [{positions: [1]}, {positions: [2]}]}", "must grow"),
    ],
)
def test_a_bad_file_is_refused_in_one_line_that_names_it(tmp_path, content, words):
    path = tmp_path / "bad.yaml"
    path.write_text(content)
    with pytest.raises(TrajectoryError, match=words) as refused:
        load_trajectory(path)
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("derivatives", [0, 1, 2])
def test_a_file_gives_back_what_was_saved(tmp_path, derivatives):
    trajectory = random_trajectory(derivatives)
    save_trajectory(tmp_path / "it.yaml", trajectory)
    loaded = load_trajectory(tmp_path / "it.yaml")
    at = np.linspace(0, trajectory.duration, 30)
    np.testing.assert_array_equal(loaded.sample(at), trajectory.sample(at))
