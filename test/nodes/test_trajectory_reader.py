"""Trajectories of any number of points, from their bytes."""

import numpy as np
import pytest

from test.nodes.graph import needs_ros
from trunk_ros.errors import TrunkError
from trunk_ros.trajectory import Trajectory

pytestmark = needs_ros


def message(joints, points, derivatives, seed=0):
    from trunk_ros.nodes.graph.messages import trajectory_message

    rng = np.random.default_rng(seed)
    values = [rng.normal(size=(points, len(joints))) for _ in range(3)]
    given = [value if order <= derivatives else None for order, value in enumerate(values)]
    made = trajectory_message(Trajectory(joints, np.cumsum(rng.uniform(0.01, 2.0, points)), *given))
    made.header.stamp.sec, made.header.frame_id = 7, "x" * (seed % 5)
    return made


def raw(made):
    from rclpy.serialization import serialize_message

    return bytes(serialize_message(made))


@pytest.mark.parametrize("joints", [("a",), ("a", "bcd"), ("joint_1", "joint_2", "joint_3")])
@pytest.mark.parametrize("derivatives", [0, 1, 2])
@pytest.mark.parametrize("points", [0, 1, 2, 49, 50, 51, 200])
def test_it_is_what_rclpy_reads(joints, derivatives, points):
    from trunk_ros.nodes.graph.ros import JointTrajectory
    from trunk_ros.nodes.graph.trajectory_reader import order_of, read_order

    made = message(joints, points, derivatives, points) if points else JointTrajectory(joint_names=joints)
    expected, found = order_of(made), read_order(raw(made))
    assert found.begin == expected.begin
    if expected.trajectory is None:
        assert found.trajectory is None
        return
    assert found.trajectory.joints == joints
    np.testing.assert_array_equal(found.trajectory.position, expected.trajectory.position)
    np.testing.assert_allclose(found.trajectory.time, expected.trajectory.time, atol=1e-9)
    for name in ("velocity", "acceleration"):
        ours, theirs = getattr(found.trajectory, name), getattr(expected.trajectory, name)
        assert (ours is None) == (theirs is None)
        assert ours is None or np.array_equal(ours, theirs)


def test_a_hundred_thousand_points_are_never_made_objects_of(monkeypatch):
    from trunk_ros.nodes.graph import trajectory_reader

    data = raw(message(("a", "b", "c"), 100_000, 1))
    monkeypatch.setattr(trajectory_reader, "unpacked", None)
    assert trajectory_reader.read_order(data).trajectory.position.shape == (100_000, 3)


def test_points_that_differ_and_bytes_that_are_none_are_refused():
    from trunk_ros.nodes.graph.trajectory_reader import read_order

    odd = message(("a", "b"), 80, 1)
    odd.points[60].velocities = []
    assert read_order(raw(odd)).trajectory.velocity is None  # as where no point has any
    odd.points[70].positions = [1.0]
    with pytest.raises(TrunkError, match="different numbers of positions"):
        read_order(raw(odd))
    rng = np.random.default_rng(1)
    good = bytearray(raw(message(("a", "b"), 80, 1)))
    for size in (0, 3, 4, 11, 12, 40, 1000):
        with pytest.raises(TrunkError):
            read_order(bytes(rng.integers(0, 256, size, dtype=np.uint8)))
        with pytest.raises(TrunkError):
            read_order(bytes(good[: 100 + size]))
