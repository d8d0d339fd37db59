"""Where the links of an arm are, each in the one before it, as TF has it."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm.arm import Arm
from trunk_ros.arm.description import Description, frame_of, read
from trunk_ros.arm.pinocchio import library
from trunk_ros.arm.urdf import urdf
from trunk_ros.compiled import Array


class Links:
    """Transforms between the links of a URDF; joints that are not asked for stand at 0."""

    def __init__(self, text: str, joints: tuple[str, ...]):
        """Raises ModelError for what is no URDF, or has not all of the joints."""
        self.pairs = [(joint.parent, joint.child) for joint in read(text)]
        """Parent and child link of each transform."""
        self._body = Description(text).found(joints).body(joints)
        model = self._body.model
        ids = {link: frame_of(model, link) for pair in self.pairs for link in pair}
        self._ends = [ids[link] for pair in self.pairs for link in pair]

    def transforms(self, theta: Array) -> Array:
        """(pairs, 7) of joint angles (joints,): x, y, z [m], quaternion x, y, z, w of children in parents."""
        poses, told = self._body.frames(theta, self._ends), library().SE3ToXYZQUAT
        return np.array([told(a.inverse() * b) for a, b in zip(poses[::2], poses[1::2], strict=True)])


class Frames(Links):
    """The same of an arm's own URDF."""

    def __init__(self, arm: Arm):
        super().__init__(urdf(arm), arm.joints)
