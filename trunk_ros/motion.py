"""Named trajectories: motions that excite what an arm may have, for ``bringup`` and experiments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.parameters import ANY_ANGLE
from trunk_ros.trajectory import Array, Trajectory, TrajectoryError, evaluate

PEAK = 1.875  # peak speed of a rest-to-rest quintic over its mean speed
FULL_CYCLE = 24.0  # s that all sections take one after the other at full size
LEAD_IN = 0.5  # s at rest before the first move
AT_REST = 1e-6  # rad
QUICKEST = 0.12  # s for the smallest moves
REACH_WITHOUT_LIMITS = 0.4  # rad
APPROACH = 0.5  # of the top speed, on the way to the middle of its range
FARTHEST = 1.0  # rad to either side, of joints that could go farther: a run is short
SEED = 134  # the one of 150 with which joints move the least alike: correlation below 0.3 from 12 s on


@dataclass(frozen=True)
class Move:
    """Go to ``target`` (in parts of the reach) at a peak ``speed`` (in parts of the top speed), then hold."""

    target: float
    speed: float
    hold: float = 0.0


Section = Callable[[np.random.Generator], list[Move]]


def sweep(rng: np.random.Generator) -> list[Move]:
    """From one end of the range to the other and back."""
    side = rng.choice([-1.0, 1.0])
    return [Move(side * rng.uniform(0.8, 0.95), 0.45), Move(-side * rng.uniform(0.8, 0.95), 0.35)]


def fast(rng: np.random.Generator) -> list[Move]:
    """Large moves near the top speed."""
    side = rng.choice([-1.0, 1.0])
    return [Move(side * rng.uniform(0.4, 0.7) * sign, 0.85) for sign in (1, -1, 1)]


def reversals(rng: np.random.Generator) -> list[Move]:
    """To and fro about a posture with ever smaller amplitude."""
    centre = rng.uniform(-0.5, 0.5)
    return [
        Move(centre + sign * size, rng.uniform(0.15, 0.35))
        for size in (0.24, 0.12, 0.06, 0.03, 0.015)
        for sign in (1, -1)
    ]


def hold(rng: np.random.Generator) -> list[Move]:
    """Postures that are kept for a while."""
    side = rng.choice([-1.0, 1.0])
    return [Move(side * 0.75, 0.5, hold=1.5), Move(-side * rng.uniform(0.3, 0.6), 0.5, hold=1.5)]


def slow(rng: np.random.Generator) -> list[Move]:
    """A short way, crawling."""
    return [Move(rng.uniform(-0.3, 0.3), 0.4)] + [Move(rng.uniform(-0.3, 0.3), 0.05) for _ in range(2)]


SECTIONS: dict[str, Section] = {
    "sweeps": sweep,
    "fast": fast,
    "reversals": reversals,
    "holds": hold,
    "slow": slow,
}
NAMES = ("default", *SECTIONS)


def named_trajectory(name: str, arm: Arm, seconds: float) -> Trajectory:
    """A motion of all joints of at most ``seconds`` s, at rest at its points' ends, the same on every call.

    ``default`` goes through all sections, each joint in an order of its own; short runs make smaller moves.
    Raises TrajectoryError for an unknown name.
    """
    if name not in NAMES:
        raise TrajectoryError(f"unknown trajectory {name!r}: give a YAML file or one of {', '.join(NAMES)}")
    sections = list(SECTIONS.values()) if name == "default" else [SECTIONS[name]]
    size = float(np.clip(seconds / FULL_CYCLE, 0.2, 1.0)) if name == "default" else 1.0
    paths = [waypoints(arm, joint, sections, seconds, size) for joint in range(len(arm.joints))]
    return merge(arm.joints, paths)


def begun_from(trajectory: Trajectory, arm: Arm, at: Mapping[str, float]) -> Trajectory:
    """The same motion, later by what the way to its first posture takes of an arm that stands ``at`` rad,
    where that is the one at rest; another one is a way of the motion's own, in a time of its own.
    """
    rest = dict(zip(arm.joints, arm.rest, strict=True))
    first = dict(zip(trajectory.joints, trajectory.position[0], strict=True))
    tops = dict(zip(arm.joints, arm.top_speed, strict=True))
    ways = [abs(angle - at.get(joint, angle)) / tops[joint] for joint, angle in first.items()]
    needed = PEAK * max(ways, default=0.0) / APPROACH - trajectory.time[0]
    if needed <= 0.0 or any(abs(angle - rest[joint]) > AT_REST for joint, angle in first.items()):
        return trajectory
    return replace(trajectory, time=trajectory.time + needed)


def waypoints(arm: Arm, joint: int, sections: list[Section], seconds: float, size: float) -> Array:
    """Postures at rest (k, 2) of one joint: time s, angle rad."""
    rng = np.random.default_rng((SEED, joint))
    centre, reach = joint_range(arm, joint)
    top = arm.top_speed[joint]
    points = [(0.0, arm.rest[joint]), (min(LEAD_IN, seconds / 4), arm.rest[joint])]
    turn = joint
    way = abs(centre - arm.rest[joint])
    if way > 0.0 and (arrival := points[-1][0] + PEAK * way / (top * APPROACH)) <= seconds:
        points.append((arrival, centre))
    while True:
        for move in sections[turn % len(sections)](rng):
            angle = centre + reach * size * move.target
            arrival = points[-1][0] + max(PEAK * abs(angle - points[-1][1]) / (top * move.speed), QUICKEST)
            if arrival > seconds:
                return np.array(points)
            points.append((arrival, angle))
            if move.hold and arrival + move.hold * size <= seconds:
                points.append((arrival + move.hold * size, angle))
        turn += 1


def joint_range(arm: Arm, joint: int) -> tuple[float, float]:
    """Centre and half-width of a joint's range [rad]."""
    lower, upper = arm.lower[joint], arm.upper[joint]
    if not max(abs(lower), abs(upper)) < ANY_ANGLE:
        return 0.0, REACH_WITHOUT_LIMITS
    reach = min(float(upper - lower) / 2, FARTHEST)
    return float(np.clip(arm.rest[joint], lower + reach, upper - reach)), reach


def merge(joints: tuple[str, ...], paths: list[Array]) -> Trajectory:
    """One trajectory of joints that come to rest at times of their own; ``paths``: (k, 2) of each joint, time
    [s] and angle [rad].

    Each joint's quintics are cut at all joints' times; the pieces are the same quintics, so nothing is lost.
    """
    times = np.unique(np.concatenate([path[1:, 0] for path in paths]).round(6))
    columns = [rest_to_rest(path, times) for path in paths]
    position, velocity, acceleration = (np.column_stack(values) for values in zip(*columns, strict=True))
    return Trajectory(joints, times, position, velocity, acceleration)


def rest_to_rest(path: Array, at: Array) -> tuple[Array, Array, Array]:
    """Position, velocity, acceleration (n,) of a joint that rests at each point of ``path`` (k, 2)."""
    still = np.zeros((len(path), 1))
    single = Trajectory(("joint",), path[:, 0], path[:, 1:], still, still)
    segment = np.clip(np.searchsorted(path[:, 0], at, side="right") - 1, 0, len(path) - 2)
    since = np.minimum(at, path[-1, 0]) - path[segment, 0]
    position, velocity, acceleration = evaluate(single.coefficients[:, segment], since[:, None])
    return position[:, 0], velocity[:, 0], acceleration[:, 0]
