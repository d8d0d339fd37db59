"""A goal of follow_joint_trajectory: its tolerances, and when it is reached, missed or broken off.

The meaning is that of ros2_controllers' joint_trajectory_controller; nothing here needs ROS.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from trunk_ros.errors import TrunkError
from trunk_ros.trajectory import Array

NONE = -1.0  # as a tolerance: take the default away


class GoalError(TrunkError):
    """A goal that is refused."""


class Code(IntEnum):
    """``error_code`` of control_msgs/FollowJointTrajectory's result, as far as an accepted goal ends so."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


@dataclass(frozen=True)
class Outcome:
    """How a goal ended, in a code and in words."""

    code: Code
    text: str


@dataclass(frozen=True)
class State:
    """Joints at one time: (joints,) rad and rad/s, NaN where unknown."""

    position: Array
    velocity: Array

    def minus(self, other: State) -> State:
        """The difference of two states."""
        return State(self.position - other.position, self.velocity - other.velocity)


@dataclass(frozen=True)
class Tolerance:
    """The largest errors that are allowed: (joints,) rad and rad/s, 0 where any is."""

    position: Array
    velocity: Array

    @staticmethod
    def same(joints: int, position: float, velocity: float = 0.0) -> Tolerance:
        """The same for all joints."""
        return Tolerance(np.full(joints, position), np.full(joints, velocity))

    def broken(self, error: State, joints: Sequence[str]) -> str:
        """Words about the first joint with too large an error, "" where there is none.

        An error that is not known is too large for any tolerance.
        """
        for values, most, unit in (
            (error.position, self.position, "rad"),
            (error.velocity, self.velocity, "rad/s"),
        ):
            bad = (most > 0) & ~(np.abs(values) <= most)
            if bad.any():
                j = int(np.argmax(bad))
                return f"{joints[j]} is off by {values[j]:.4g} {unit}, more than {most[j]:.4g} {unit}"
        return ""


@dataclass(frozen=True)
class Goal:
    """What a goal asks: ``path`` before its end [s of the node's clock], ``goal`` after it.

    ``leeway``: s after the end in which ``goal`` has to be reached; 0: for ever.
    """

    joints: tuple[str, ...]
    end: float
    path: Tolerance
    goal: Tolerance
    leeway: float = 0.0

    def judge(self, now: float, wanted: State, actual: State) -> Outcome | None:
        """How the goal has ended, None while it has not."""
        error = wanted.minus(actual)
        if now < self.end:
            words = self.path.broken(error, self.joints)
            return Outcome(Code.PATH_TOLERANCE_VIOLATED, f"on the way {words}") if words else None
        words = self.goal.broken(error, self.joints)
        if not words:
            return Outcome(Code.SUCCESSFUL, "goal reached")
        if self.leeway and now > self.end + self.leeway:
            return Outcome(Code.GOAL_TOLERANCE_VIOLATED, f"{self.leeway:g} s after the end {words}")
        return None


def leeway(asked: Any, default: float) -> float:
    """Seconds of a ``goal_time_tolerance``: 0 keeps the default, -1 s is for ever.

    Raises GoalError for any other negative time.
    """
    return chosen(asked.sec + asked.nanosec * 1e-9, default, "the time of the goal")


def overlaid(given: Sequence[Any], joints: tuple[str, ...], default: Tolerance) -> Tolerance:
    """A goal's JointTolerances over the node's own: 0 keeps the default, -1 takes it away.

    Raises GoalError for a joint that the arm does not have and for any other negative tolerance.
    """
    position, velocity = default.position.copy(), default.velocity.copy()
    for each in given:
        if each.name not in joints:
            raise GoalError(f"a tolerance is for {each.name!r}: the arm has {', '.join(joints)}")
        j = joints.index(each.name)
        position[j] = chosen(each.position, position[j], each.name)
        velocity[j] = chosen(each.velocity, velocity[j], each.name)
    return Tolerance(position, velocity)


def chosen(asked: float, default: float, what: str) -> float:
    """A tolerance that is asked for, over a default. Raises GoalError where it makes no sense."""
    if asked == 0:
        return default
    if asked == NONE:
        return 0.0
    if not asked > 0:
        raise GoalError(f"the tolerance {asked:g} for {what} is neither positive nor 0 nor -1")
    return asked
