"""Joint trajectories with the meaning that ros2_controllers' joint_trajectory_controller gives them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from trunk_ros.errors import TrunkError
from trunk_ros.recording import plain_yaml

Array = NDArray[np.float64]

CHECKS_PER_SEGMENT = 32
FINEST = 1e-3  # s between two checks: no loop sees more
TOLERANCE = 1e-9


class TrajectoryError(TrunkError):
    """A trajectory is malformed or breaks a limit."""


@dataclass(frozen=True)
class Limits:
    """What a joint may do: (joints,) arrays of rad, rad/s and rad/s^2 (``inf`` where there is no limit)."""

    lower: Array
    upper: Array
    speed: Array
    acceleration: Array


@dataclass(frozen=True)
class Trajectory:
    """Points of a motion: ``time`` (k,) s from its start, the rest (k, joints) rad, rad/s, rad/s^2.

    Between points it is linear where only positions are given, cubic with velocities, quintic with
    accelerations as well. Raises TrajectoryError where the points cannot be followed.
    """

    joints: tuple[str, ...]
    time: Array
    position: Array
    velocity: Array | None = None
    acceleration: Array | None = None

    def __post_init__(self) -> None:
        if len(set(self.joints)) != len(self.joints):
            raise TrajectoryError(f"a joint is named twice in {', '.join(self.joints)}")
        if not len(self.time):
            raise TrajectoryError("the trajectory has no points")
        if not np.all(np.isfinite(self.time)):
            raise TrajectoryError("time_from_start is not finite")
        if self.time[0] < 0 or np.any(np.diff(self.time) <= 0):
            raise TrajectoryError("time_from_start must grow from point to point, and not start below 0")
        for name in ("position", "velocity", "acceleration"):
            self._check_shape(name, getattr(self, name))

    def _check_shape(self, name: str, values: Array | None) -> None:
        if values is None:
            return
        if values.shape != (len(self.time), len(self.joints)):
            raise TrajectoryError(f"each point needs one {name} for each of the {len(self.joints)} joints")
        if not np.all(np.isfinite(values)):
            raise TrajectoryError(
                f"{name} of {self.joints[np.argwhere(~np.isfinite(values))[0][1]]} is not finite"
            )

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return float(self.time[-1])

    def sample(self, at: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity, acceleration, each (n, joints), at times (n,) s; it rests before and after."""
        at = np.atleast_1d(np.asarray(at, dtype=float))
        if len(self.time) == 1:
            rest = np.zeros((len(at), len(self.joints)))
            return rest + self.position[0], rest, rest
        segment = np.clip(np.searchsorted(self.time, at, side="right") - 1, 0, len(self.time) - 2)
        since = np.clip(at, self.time[0], self.time[-1]) - self.time[segment]
        moving = ((at >= self.time[0]) & (at < self.time[-1]))[:, None]
        position, velocity, acceleration = evaluate(self.coefficients[:, segment], since[:, None])
        position[at >= self.time[-1]] = self.position[-1]
        return position, np.where(moving, velocity, 0.0), np.where(moving, acceleration, 0.0)

    @cached_property
    def coefficients(self) -> Array:
        """Polynomial of each segment in s since its start, (6, k-1, joints), lowest power first."""
        span = np.diff(self.time)[:, None]
        c = np.zeros((6, len(span), len(self.joints)))
        c[0] = self.position[:-1]
        change = np.diff(self.position, axis=0)
        if self.velocity is None:
            c[1] = change / span
            return c
        v0, v1 = self.velocity[:-1], self.velocity[1:]
        c[1] = v0
        if self.acceleration is None:
            c[2] = (3 * change / span - 2 * v0 - v1) / span
            c[3] = (v0 + v1 - 2 * change / span) / span**2
            return c
        a0, a1 = self.acceleration[:-1], self.acceleration[1:]
        c[2] = a0 / 2
        c[3] = (20 * change - (8 * v1 + 12 * v0) * span - (3 * a0 - a1) * span**2) / (2 * span**3)
        c[4] = (-30 * change + (14 * v1 + 16 * v0) * span + (3 * a0 - 2 * a1) * span**2) / (2 * span**4)
        c[5] = (12 * change - 6 * (v0 + v1) * span - (a0 - a1) * span**2) / (2 * span**5)
        return c

    def after(self, position: Array, velocity: Array, acceleration: Array) -> Trajectory:
        """The same motion begun from a state (joints,) at time 0; as it is where it has a point there."""
        late = self.time > 0
        if not late.any() or not late[0]:
            return self
        return replace(
            self,
            time=np.concatenate([[0.0], self.time]),
            position=np.vstack([position, self.position]),
            velocity=None if self.velocity is None else np.vstack([velocity, self.velocity]),
            acceleration=None if self.acceleration is None else np.vstack([acceleration, self.acceleration]),
        )

    def for_joints(self, joints: tuple[str, ...], held: Array) -> Trajectory:
        """The motion in the order of ``joints``; those that it does not name stay at ``held`` (joints,) rad.

        Raises TrajectoryError for a joint that is not among them.
        """
        if unknown := [joint for joint in self.joints if joint not in joints]:
            raise TrajectoryError(f"unknown joint {unknown[0]!r}: the arm has {', '.join(joints)}")
        columns = [joints.index(joint) for joint in self.joints]

        def spread(values: Array | None, rest: Array) -> Array | None:
            if values is None:
                return None
            full = np.tile(rest, (len(self.time), 1))
            full[:, columns] = values
            return full

        still = np.zeros(len(joints))
        position = spread(self.position, held)
        assert position is not None
        return Trajectory(
            joints, self.time, position, spread(self.velocity, still), spread(self.acceleration, still)
        )

    def check(self, limits: Limits) -> None:
        """Raise TrajectoryError naming the first limit that the motion would break, where and when.

        A start outside the position limits is allowed as long as the motion does not go further out.
        """
        at = self._instants()
        position, velocity, acceleration = self.sample(at)
        low = np.minimum(limits.lower, position[0]) - TOLERANCE
        high = np.maximum(limits.upper, position[0]) + TOLERANCE
        self._refuse(at, position, position < low, "reach", "rad", limits.lower)
        self._refuse(at, position, position > high, "reach", "rad", limits.upper)
        self._refuse(
            at, velocity, np.abs(velocity) > limits.speed + TOLERANCE, "move at", "rad/s", limits.speed
        )
        if self.velocity is not None:
            hard = np.abs(acceleration) > limits.acceleration + TOLERANCE
            self._refuse(at, acceleration, hard, "accelerate at", "rad/s^2", limits.acceleration)

    def _instants(self) -> Array:
        """Times at which the limits are checked: on straight lines the points tell all."""
        if self.velocity is None:
            return self.time
        span = np.diff(self.time)
        number = np.clip(np.ceil(span / FINEST), 2, CHECKS_PER_SEGMENT).astype(int)
        share = np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
        inside = np.repeat(self.time[:-1], number) + share * np.repeat(span / number, number)
        return np.append(inside, self.time[-1])

    def _refuse(self, at: Array, values: Array, broken: Any, verb: str, unit: str, limit: Array) -> None:
        if not broken.any():
            return
        k, j = np.argwhere(broken)[0]
        raise TrajectoryError(
            f"{self.joints[j]} would {verb} {values[k, j]:.4g} {unit} at {at[k]:.3f} s: "
            f"its limit is {limit[j]:.4g} {unit}"
        )


def evaluate(c: Array, since: Array) -> tuple[Array, Array, Array]:
    """Value and first two derivatives of polynomials ``c`` (6, n, joints) at ``since`` (n, 1) s."""
    value, slope, bend = (np.zeros_like(c[0]) for _ in range(3))
    for coefficient in c[::-1]:
        bend = bend * since + 2 * slope
        slope = slope * since + value
        value = value * since + coefficient
    return value, slope, bend


def load_trajectory(path: str | Path) -> Trajectory:
    """Read a YAML file with the fields of trajectory_msgs/JointTrajectory; times in s or ``{sec, nanosec}``.

    Raises TrajectoryError that names the file and the field.
    """
    try:
        return from_fields(plain_yaml.load(Path(path).read_bytes(), references=False))
    except OSError as error:
        raise TrajectoryError(f"cannot read the trajectory {path}: {error.strerror}") from None
    except TrajectoryError as error:
        raise TrajectoryError(f"{path}: {error}") from None
    except ValueError as error:
        raise TrajectoryError(f"{path} {error}") from None


def save_trajectory(path: str | Path, trajectory: Trajectory) -> None:
    """Write the file that ``load_trajectory`` reads."""
    named = {
        "positions": trajectory.position,
        "velocities": trajectory.velocity,
        "accelerations": trajectory.acceleration,
    }
    points = [
        {name: values[k].tolist() for name, values in named.items() if values is not None}
        | {"time_from_start": float(trajectory.time[k])}
        for k in range(len(trajectory.time))
    ]
    fields = {"joint_names": list(trajectory.joints), "points": points}
    Path(path).write_text(yaml.safe_dump(fields, sort_keys=False, default_flow_style=None))


def from_fields(fields: Any) -> Trajectory:
    """A trajectory of the message's fields as plain dictionaries and lists. Raises TrajectoryError."""
    if not isinstance(fields, dict) or not fields.get("joint_names") or not fields.get("points"):
        raise TrajectoryError("a trajectory needs joint_names and points")
    points = fields["points"]
    if not isinstance(fields["joint_names"], list) or not isinstance(points, list):
        raise TrajectoryError("joint_names and points must be lists")
    try:
        return Trajectory(
            tuple(str(joint) for joint in fields["joint_names"]),
            np.array([seconds(point.get("time_from_start", 0.0)) for point in points]),
            np.array([point["positions"] for point in points], dtype=float),
            column(points, "velocities"),
            column(points, "accelerations"),
        )
    except KeyError as error:
        raise TrajectoryError(f"a point lacks {error.args[0]}") from None
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise TrajectoryError(f"a point is not a set of numbers: {error}") from None


def column(points: list[Any], name: str) -> Array | None:
    """One field of all points (k, joints), or None where not every point has it."""
    return (
        np.array([point[name] for point in points], dtype=float) if all(p.get(name) for p in points) else None
    )


def seconds(time: Any) -> float:
    """A time given as a number, or as ``sec`` and ``nanosec``."""
    return time.get("sec", 0) + time.get("nanosec", 0) * 1e-9 if isinstance(time, dict) else float(time)
