"""What joint_trajectory_controller does with trajectories: replace on arrival, hold at the end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.trajectory import Array, Limits, Trajectory, TrajectoryError

EXPONENTS = np.arange(6.0)
SHIFTED = np.array([np.maximum(np.arange(6) - order, 0) for order in range(3)])
FACTORS = np.array([np.ones(6), np.arange(6.0), np.arange(6.0) * (np.arange(6.0) - 1)])  # of derivatives
STILL = 1e-6  # rad/s
START_TOLERANCE = 0.02  # rad between the arm and a point that is due at once


class Follower:
    """The reference of all joints over time; times are seconds of the node's clock."""

    def __init__(self, joints: tuple[str, ...], limits: Limits, position: Array):
        self.joints = joints
        self.limits = limits
        self._held = position.copy()
        self._active: Trajectory | None = None
        self._begin = 0.0

    @property
    def position(self) -> Array:
        """The last reference (joints,) rad."""
        return self._held

    def moving(self, now: float) -> bool:
        """Whether a trajectory is still under way."""
        return self._active is not None and now < self._begin + self._active.duration

    def sample(self, now: float) -> tuple[Array, Array, Array]:
        """Reference position, velocity and acceleration, each (joints,)."""
        position, velocity, acceleration = self.state(now)
        self._held = position
        return position, velocity, acceleration

    def hold(self, position: Array) -> None:
        """Stay at a position (joints,) rad, whatever was under way."""
        self._held = position.copy()
        self._active = None

    def stop(self, now: float) -> None:
        """Stay where the reference is now."""
        self.sample(now)
        self._active = None

    def follow(self, trajectory: Trajectory, now: float, begin: float | None = None) -> float:
        """Replace what is under way; returns when it ends [s].

        ``begin``: when its time 0 is, by default now; past points are left out.

        Raises TrajectoryError with the reason, and goes on with what was under way, where a joint is unknown,
        a limit would be broken, all points are past, the last is not at rest, or the first is due at once
        somewhere else.
        """
        position, velocity, acceleration = self.state(now)
        plan = trajectory.for_joints(self.joints, position)
        plan = remaining(plan, (now if begin is None else begin) - now)
        if plan.time[0] == 0 and np.max(np.abs(plan.position[0] - position)) > START_TOLERANCE:
            raise TrajectoryError(
                "its first point is due at once but elsewhere: give it a later time_from_start"
            )
        plan = plan.after(position, velocity, acceleration)
        plan.check(self.limits)
        check_rest(plan)
        self._active, self._begin = plan, now
        return now + plan.duration

    def state(self, now: float) -> tuple[Array, Array, Array]:
        """What `sample` gives, without moving there."""
        if self._active is None:
            rest = np.zeros(len(self.joints))
            return self._held, rest, rest
        return state_at(self._active, now - self._begin)


def state_at(plan: Trajectory, at: float) -> tuple[Array, Array, Array]:
    """What ``plan.sample`` gives for one time [s], each (joints,), fast enough for a control loop."""
    k = int(plan.time.searchsorted(at, side="right")) - 1
    if k < 0 or k >= len(plan.time) - 1:
        rest = np.zeros(len(plan.joints))
        return plan.position[max(k, 0)], rest, rest
    powers = (at - plan.time[k]) ** EXPONENTS
    value, slope, bend = (FACTORS * powers[SHIFTED]) @ plan.coefficients[:, k]
    return value, slope, bend


def limits_of(arm: Arm, acceleration: float) -> Limits:
    """What a trajectory may ask of an arm's joints; ``acceleration`` rad/s^2 at most."""
    return Limits(arm.lower, arm.upper, arm.top_speed, np.full(len(arm.joints), acceleration))


def check_rest(plan: Trajectory) -> None:
    """Raise TrajectoryError where a joint would still move at the last point, from which on it is held."""
    if plan.velocity is not None and (moving := np.abs(plan.velocity[-1]) > STILL).any():
        j = int(np.argmax(moving))
        raise TrajectoryError(
            f"{plan.joints[j]} would still move at {plan.velocity[-1, j]:.4g} rad/s at the last point: "
            "give it velocity 0 there"
        )


def remaining(plan: Trajectory, delay: float) -> Trajectory:
    """The points that are still to come of a motion that begins after ``delay`` s (negative: began already).

    Raises TrajectoryError where there is none.
    """
    time = plan.time + delay
    ahead = time >= 0
    if not ahead.any():
        raise TrajectoryError(f"its last point was due {-time[-1]:.3f} s ago")

    def cut(values: Array | None) -> Array | None:
        return None if values is None else values[ahead]

    return replace(
        plan,
        time=time[ahead],
        position=plan.position[ahead],
        velocity=cut(plan.velocity),
        acceleration=cut(plan.acceleration),
    )
