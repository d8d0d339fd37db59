"""The load on the joints from the torque of the motors: against the load, plus friction in the direction of
motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.derivatives import HALF_WINDOW, smooth
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.fill import fill

MOVES = 5e-3  # rad/s of the shaft, from which on its friction takes a side
LEAST = 50  # samples in each direction, fewer cannot tell friction from load
SPAN = 0.1  # s on either side over which torque is averaged


@dataclass(frozen=True)
class MeasuredLoad:
    """Of each joint what its motor's torque says."""

    moment: Array
    """(n, joints) N m, positive where it tends to increase the joint angle; NaN for joints that do not move
    both ways: their friction cannot be told from their load."""
    friction: Array
    """(joints,) N m at the shaft, NaN likewise."""
    moving: np.ndarray
    """(n, joints): where the moment was measured; where a shaft stands it is what its posture asks for."""


def measured_load(gearbox: JointSeries, ratio: Array, arm: Arm | None = None) -> MeasuredLoad:
    """Load from recorded effort; ``ratio`` (joints,) joint angle per shaft angle.

    Torque is regressed on posture, acceleration, speed and direction of motion. Posture: sine and cosine of
    each link's heading, as of a planar chain; of an ``arm`` with a URDF what any masses of its links would
    ask for. What goes with direction and speed is friction. Where a shaft stands, its friction may be
    anything, so that the moment there is the posture's, with what it lacks drawn from before and after.
    """
    assert gearbox.effort is not None
    position, effort = fill(gearbox.position), fill(gearbox.effort)
    angle, speed, acceleration = smooth(gearbox.stamp, position)
    postures = _postures(angle * ratio, arm)
    way = np.where(np.abs(speed) > MOVES, np.sign(speed), 0.0)
    known = np.isfinite(gearbox.effort)
    columns = [
        _of_joint(
            gearbox.stamp,
            np.column_stack([postures[j], acceleration]),
            speed[:, j],
            way[:, j],
            effort[:, j],
            known[:, j],
        )
        for j in range(len(ratio))
    ]
    torque, moving = (np.column_stack([c[k] for c in columns]) for k in (0, 1))
    friction = np.array([c[2] for c in columns])
    return MeasuredLoad(-torque / ratio, friction, moving)


def _postures(theta: Array, arm: Arm | None) -> list[Array]:
    """For each joint (n, columns) what its load at joint angles (n, joints) is made of."""
    level = np.ones(len(theta))
    if arm is None or arm.description is None:
        heading = np.cumsum(theta, axis=1)
        sides = [(np.sin(heading[:, j:]), np.cos(heading[:, j:])) for j in range(theta.shape[1])]
        return [np.column_stack([level, *both]) for both in sides]
    shares = arm.body.weight_shares(theta, arm.pull)
    return [np.column_stack([level, *(c for c in shares[:, j].T if c.any())]) for j in range(theta.shape[1])]


def _of_joint(
    stamp: Array, posture: Array, speed: Array, way: Array, effort: Array, known: np.ndarray
) -> tuple[Array, np.ndarray, float]:
    """Torque (n,) without friction, where it was measured, and friction."""
    seen = known & (way != 0.0) & _settled(stamp, way)
    if min((way[seen] > 0.0).sum(), (way[seen] < 0.0).sum()) < LEAST:
        return np.full(len(way), np.nan), seen & False, np.nan
    design = np.column_stack([posture, way, speed])
    weights, *_ = np.linalg.lstsq(design[seen], effort[seen], rcond=1e-9)
    rest = effort - design @ weights
    off = np.interp(stamp, stamp[seen], rest[seen])
    torque = posture @ weights[:-2] + smooth(stamp, off[:, None], SPAN)[0][:, 0]
    return torque, seen, float(weights[-2])


def _settled(stamp: Array, way: Array) -> np.ndarray:
    """(n,): where the direction of motion does not change as near as what it was taken from."""
    turns = stamp[1:][np.diff(way) != 0.0]
    after = np.searchsorted(turns, stamp, side="right")
    ends = np.concatenate([[-np.inf], turns, [np.inf]])
    return np.asarray((stamp - ends[after] > HALF_WINDOW) & (ends[after + 1] - stamp > HALF_WINDOW))
