"""The planar chain: upright base, axes along X, each link along Z with its mass at its middle."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from trunk_ros.arm.body import Body
from trunk_ros.arm.pinocchio import library


@lru_cache(maxsize=32)
def planar(length: tuple[float, ...], mass: tuple[float, ...]) -> Body:
    """A body of links ``length`` [m] with point masses ``mass`` [kg], one of each per joint."""
    pin = library()
    model, parent, height = pin.Model(), 0, 0.0
    for j, (reach, weight) in enumerate(zip(length, mass, strict=True)):
        parent = model.addJoint(parent, pin.JointModelRX(), _up(height), f"joint_{j + 1}")
        lump = pin.Inertia(weight, np.array([0.0, 0.0, reach / 2]), np.zeros((3, 3)))
        model.appendBodyToJoint(parent, lump, pin.SE3.Identity())
        height = reach
    tip = model.addFrame(pin.Frame("tip", parent, 0, _up(height), pin.FrameType.OP_FRAME))
    joints = len(length)
    path = tuple(range(1, joints + 1))
    return Body(model, tip, pin.SE3.Identity(), np.eye(joints), np.zeros(joints), path)


def _up(height: float) -> object:
    return library().SE3(np.eye(3), np.array([0.0, 0.0, height]))
