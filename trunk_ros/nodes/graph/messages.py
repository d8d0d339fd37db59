"""Messages to arrays and back; stamps are integer nanoseconds."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np

from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.joints import JointMatcher
from trunk_ros.nodes.graph.ros import JointState, JointTrajectory, JointTrajectoryPoint, Time
from trunk_ros.trajectory import Array, Trajectory, TrajectoryError

NONE = array("d")


def nanoseconds(stamp: Any) -> int:
    """A stamp or duration message in ns."""
    return int(stamp.sec) * SECOND + int(stamp.nanosec)


def time_message(ns: int) -> Any:
    """The stamp message of a time in ns."""
    return set_time(Time(), ns)


def set_time(stamp: Any, ns: int) -> Any:
    """Set a stamp message to a time in ns."""
    stamp.sec, stamp.nanosec = divmod(ns, SECOND)
    return stamp


def joint_state(
    ns: int, names: Sequence[str], position: Array, velocity: Array | None = None, effort: Array | None = None
) -> Any:
    """A JointState of (joints,) arrays; what is None stays empty."""
    return fill(JointState(name=list(names)), ns, position, velocity, effort)


def fill(
    message: Any, ns: int, position: Array, velocity: Array | None = None, effort: Array | None = None
) -> Any:
    """Put stamp and (joints,) arrays into a JointState, whose names stay; what is None becomes empty."""
    set_time(message.header.stamp, ns)
    message.position = doubles(position)
    message.velocity = NONE if velocity is None else doubles(velocity)
    message.effort = NONE if effort is None else doubles(effort)
    return message


def doubles(values: Array) -> Any:
    """What a float64[] field takes without looking at each element."""
    return array("d", np.ascontiguousarray(values, dtype=float).tobytes())


def state_of(message: Any, matcher: JointMatcher) -> State:
    """Position and velocity (joints,) of a JointState; a velocity that it does not give counts as none.

    Raises MessageError where names and values do not go together.
    """
    position = matcher.angles(message.name, message.position)
    velocity = matcher.gather(message.name, message.velocity)
    return State(position, np.where(np.isfinite(velocity), velocity, 0.0))


def point(state: State) -> Any:
    """A JointTrajectoryPoint of a state (joints,)."""
    return JointTrajectoryPoint(positions=doubles(state.position), velocities=doubles(state.velocity))


def fill_pose(message: Any, ns: int, frame: str, tip: Array) -> Any:
    """Put a tip (7,), x, y, z m, quaternion x, y, z, w, into a PoseStamped."""
    set_time(message.header.stamp, ns)
    message.header.frame_id = frame
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = tip.tolist()
    return message


def trajectory_of(message: Any) -> Trajectory:
    """A trajectory message's points. Raises TrajectoryError where they do not fit together."""
    points = message.points
    try:
        position = np.array([p.positions for p in points], dtype=float)
    except ValueError:
        raise TrajectoryError("its points have different numbers of positions") from None
    if any(len(p.positions) != len(message.joint_names) for p in points):
        raise TrajectoryError(
            f"each point needs one position for each of the {len(message.joint_names)} joints"
        )
    return Trajectory(
        tuple(message.joint_names),
        np.array([nanoseconds(p.time_from_start) / SECOND for p in points]),
        position,
        derivative([p.velocities for p in points], "velocities"),
        derivative([p.accelerations for p in points], "accelerations"),
    )


def derivative(rows: list[Any], name: str) -> Array | None:
    """Velocities or accelerations (k, joints), None where a point has none."""
    if not all(len(row) for row in rows):
        return None
    if len({len(row) for row in rows}) > 1:
        raise TrajectoryError(f"its points have different numbers of {name}")
    return np.array(rows, dtype=float)


def trajectory_message(trajectory: Trajectory) -> Any:
    """A message that begins on arrival."""
    message = JointTrajectory(joint_names=list(trajectory.joints))
    for k, at in enumerate(trajectory.time):
        point = JointTrajectoryPoint(positions=doubles(trajectory.position[k]))
        if trajectory.velocity is not None:
            point.velocities = doubles(trajectory.velocity[k])
        if trajectory.acceleration is not None:
            point.accelerations = doubles(trajectory.acceleration[k])
        ns = round(at * SECOND)
        point.time_from_start.sec, point.time_from_start.nanosec = ns // SECOND, ns % SECOND
        message.points.append(point)
    return message
