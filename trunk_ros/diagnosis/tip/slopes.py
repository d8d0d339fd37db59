"""How the tip moves with each value of the arm's geometry."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm.body import Body
from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core


class Slopes:
    """Derivatives of the tip's pose (n, 6), m along and rad about the base's axes, at angles (n, joints).

    Every value is a small shift or turn of all that comes after it: Mooring, Roth & Driels, Fundamentals of
    Manipulator Calibration (1991), ch. 4.
    """

    def __init__(self, body: Body, theta: Array):
        self.body, self.theta = body, theta
        self.place, self.turn = body.places(theta)
        self.jacobian = body.jacobian(theta)

    def of(self, change: Core) -> Array:
        """(n, 6) of a small change of the arm's geometry."""
        geometry, n = change.geometry, len(self.theta)
        out = np.zeros((n, 6))
        for c in np.flatnonzero(geometry.shift.any(axis=1)):
            out[:, :3] += self.turn[:, c] @ geometry.shift[c]
        for c in np.flatnonzero(geometry.tilt.any(axis=1)):
            out += self._tilted(int(c), geometry.tilt[c])
        more = geometry.zero + change.bent
        if np.any(more):
            out += np.einsum("nij,nj->ni", self.jacobian, np.broadcast_to(more, self.theta.shape))
        if geometry.base.any():
            out[:, :3] += geometry.base[:3] + np.cross(geometry.base[3:], self.place[:, -1])
            out[:, 3:] += geometry.base[3:]
        if geometry.tool.any():
            out[:, :3] += self.turn[:, -1] @ geometry.tool[:3]
            out[:, 3:] += self.turn[:, -1] @ geometry.tool[3:]
        return out

    def _tilted(self, c: int, about: Array) -> Array:
        """The frame of a joint turns before the joint moves, and back after it."""
        axis, q, after = self.body.axes[c], self.theta[:, c : c + 1], self.turn[:, c]
        if self.body.slides[c]:
            return np.hstack([np.cross(after @ about, (after @ axis) * q), np.zeros((len(q), 3))])
        before = about * np.cos(q) - np.cross(axis, about) * np.sin(q)
        turned = np.einsum("nij,nj->ni", after, before - about)
        return np.hstack([np.cross(turned, self.place[:, -1] - self.place[:, c]), turned])
