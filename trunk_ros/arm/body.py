"""Rigid links on joints: load, inertia, tip and its Jacobian, by Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from trunk_ros.arm.pinocchio import library
from trunk_ros.arm.weight import Tree, frames, mass_matrix, tree_of, weigh
from trunk_ros.compiled import Array

KEPT = 8  # models with a payload that are kept
TOGETHER = 4096  # rows that are spread over the joints at once


@dataclass(frozen=True, eq=False)
class Body:
    """A tree of links whose joints follow those of the arm: (nv,) q = ``spread`` theta + ``offset``.

    Joints of the arm are revolute (rad, N m) or prismatic (m, N).
    """

    model: Any
    """Pinocchio's model, without payload: every joint of one degree of freedom, the others locked."""
    tip: int
    """The tip's frame in it."""
    base: Any
    """Pose (SE3) of the base link in the model's root."""
    spread: Array
    """(nv, joints): 1 where a joint is the arm's, the multiplier where it mimics one."""
    offset: Array
    """(nv,) rad or m."""
    path: tuple[int, ...]
    """The model's joints on the way from base to tip."""
    _loaded: dict[Any, tuple[Any, Any, Tree]] = field(default_factory=dict, repr=False)

    @cached_property
    def own(self) -> tuple[int, ...]:
        """The model's joints that are the arm's own, in the arm's order."""
        rows = [int(np.flatnonzero(column == 1.0)[0]) for column in self.spread.T]
        by_row = {self.model.joints[i].idx_v: i for i in range(1, self.model.njoints)}
        return tuple(by_row[row] for row in rows)

    @cached_property
    def along(self) -> Array:
        """(joints, 3) unit vectors from each joint to the next on the way to the tip, in the joint's frame; 0
        where they are at one place, or the joint is not on the way.
        """
        placed = [self.model.jointPlacements[i].translation for i in self.path[1:]]
        reach = dict(
            zip(self.path, [*placed, self.model.frames[self.tip].placement.translation], strict=True)
        )
        links = np.array([reach.get(i, np.zeros(3)) for i in self.own])
        size = np.linalg.norm(links, axis=1, keepdims=True)
        return np.asarray(np.where(size > 1e-9, links / np.maximum(size, 1e-9), 0.0))

    @cached_property
    def axes(self) -> Array:
        """(joints, 3) unit vectors along which or about which each joint moves, in its frame."""
        motions = [np.ravel(self.model.joints[i].createData().S) for i in self.own]
        return np.array([motion[:3] if motion[:3].any() else motion[3:] for motion in motions])

    @cached_property
    def across(self) -> Array:
        """(joints, 2, 3) unit vectors across ``along``."""
        return across(self.along)

    @cached_property
    def beside(self) -> Array:
        """(joints, 2, 3) unit vectors across ``axes``."""
        return across(self.axes)

    @cached_property
    def slides(self) -> np.ndarray:
        """(joints,): which are prismatic."""
        return np.array([bool(np.ravel(self.model.joints[i].createData().S)[:3].any()) for i in self.own])

    @cached_property
    def mass(self) -> float:
        """What the joints carry [kg], payload aside."""
        return float(sum(inertia.mass for inertia in list(self.model.inertias)[1:]))

    def moments(
        self,
        theta: Array,
        gravity: Array,
        payload: float = 0.0,
        speed: Array | None = None,
        acceleration: Array | None = None,
        links: bool = True,
    ) -> Array:
        """What weight and inertia do to the joints, (n, joints) N m or N: -(M q'' + C q' + g), positive where
        it tends to increase the joint's value.

        ``theta``, ``speed``, ``acceleration`` (n, joints); ``gravity`` (3,) m/s^2 in the base's axes;
        ``payload`` kg at the tip; without ``links`` it is all that has mass.
        """
        pin = library()
        model, data, tree = self._with(payload, links)
        pull = self.base.rotation @ np.asarray(gravity, dtype=float)
        if speed is None and acceleration is None:
            return self._weight(theta, pull, tree)
        q = self._whole(theta) + self.offset
        model.gravity.linear = pull
        still = np.zeros_like(q)
        v = still if speed is None else self._whole(speed)
        a = still if acceleration is None else self._whole(acceleration)
        if len(q) == 1:  # a node's tick
            return np.asarray(-pin.rnea(model, data, q[0], v[0], a[0])[None] @ self.spread)
        out = np.empty((model.nv, len(q)), order="F")
        motion = (np.asfortranarray(each.T) for each in (q, v, a))
        pin.rneaInParallel(1, pin.ModelPool(model, 1), *motion, out)
        return np.asarray(-out.T @ self.spread)

    def _weight(self, theta: Array, pull: Array, tree: Tree) -> Array:
        """(n, joints) by pieces: what lies between angles and moments takes no memory."""
        out = np.empty((len(theta), self.spread.shape[1]))
        for first in range(0, len(theta), TOGETHER):
            q = self._whole(theta[first : first + TOGETHER]) + self.offset
            weight = np.empty_like(q)
            weigh(q, pull, tree, weight)
            out[first : first + TOGETHER] = weight @ self.spread
        return out

    def weight_shares(self, theta: Array, gravity: Array) -> Array:
        """(n, joints, columns): what a kilogram and a kilogram metre along each axis in each link would do to
        the joints, as ``moments`` has it: the weight is a sum of these, whatever the masses.
        """
        pin = library()
        model, data, _ = self._with(0.0, True)
        model.gravity.linear = self.base.rotation @ np.asarray(gravity, dtype=float)
        q, still = self._whole(theta) + self.offset, np.zeros(model.nv)
        static = np.add.outer(10 * np.arange(model.njoints - 1), np.arange(4)).ravel()
        out = np.empty((len(q), model.nv, len(static)))
        for k in range(len(q)):
            shares = pin.computeJointTorqueRegressor(model, data, q[k], still, still)
            out[k] = np.reshape(shares, (model.nv, -1))[:, static]  # of one joint it comes as a row
        return np.asarray(-self.spread.T @ out)

    def last_link_shares(self, theta: Array, speed: Array, acceleration: Array, gravity: Array) -> Array:
        """(n, joints, 10): what each parameter of the last link asks of the joints in a motion (n, joints):
        mass, first moments and moments of inertia about its joint, as Pinocchio orders them.
        """
        pin = library()
        model, data, _ = self._with(0.0, True)
        model.gravity.linear = self.base.rotation @ np.asarray(gravity, dtype=float)
        q = self._whole(theta) + self.offset
        v, a = self._whole(speed), self._whole(acceleration)
        first = 10 * (self.own[self.last] - 1)
        out = np.empty((len(q), model.nv, 10))
        for k in range(len(q)):
            shares = pin.computeJointTorqueRegressor(model, data, q[k], v[k], a[k])
            out[k] = np.reshape(shares, (model.nv, -1))[:, first : first + 10]
        return np.asarray(self.spread.T @ out)

    @property
    def last(self) -> int:
        """Which of the arm's joints is the last on the way to the tip."""
        return self.own.index(next(i for i in reversed(self.path) if i in self.own))

    @property
    def last_link(self) -> Any:
        """Pinocchio's inertia of all that is fixed to the last joint, payload aside, in the joint's frame."""
        return self.model.inertias[self.own[self.last]]

    def mass_matrix(self, theta: Array, payload: float = 0.0) -> Array:
        """M (n, joints, joints) kg m^2 of joint angles (n, joints)."""
        own = self._matrix(theta, 0.0, True)
        return own if payload == 0.0 else own + payload * self.mass_lever(theta)

    def mass_lever(self, theta: Array) -> Array:
        """What a kilogram at the tip adds to it, whatever the masses, (n, joints, joints) kg m^2 per kg."""
        return self._matrix(theta, 1.0, False)

    def _matrix(self, theta: Array, payload: float, links: bool) -> Array:
        tree, joints = self._with(payload, links)[2], self.spread.shape[1]
        q = self._whole(theta) + self.offset
        out = np.empty((len(q), joints, joints))
        for first in range(0, len(q), TOGETHER):  # what is not spread yet is needed once more
            some = np.empty((min(TOGETHER, len(q) - first), q.shape[1], q.shape[1]))
            mass_matrix(q[first : first + TOGETHER], tree, some)
            out[first : first + TOGETHER] = self.spread.T @ some @ self.spread
        return out

    def poses(self, theta: Array) -> Array:
        """Tip (n, 7) in the base link: x, y, z [m] and the quaternion x, y, z, w."""
        pin = library()
        model, data, _ = self._with(0.0, True)
        q, back = self._whole(theta) + self.offset, self.base.inverse()
        out = np.empty((len(q), 7))
        for k in range(len(q)):
            pin.framesForwardKinematics(model, data, q[k])
            out[k] = pin.SE3ToXYZQUAT(back * data.oMf[self.tip])
        return out

    def places(self, theta: Array) -> tuple[Array, Array]:
        """Positions (n, joints + 1, 3) and rotations (n, joints + 1, 3, 3) of the joints' frames and the tip,
        in the base link.
        """
        turn, place = self._frames(theta)
        back, tip, rows = self.base.inverse(), self.model.frames[self.tip], list(self.own)
        end = self._end(turn, place)
        place = np.concatenate([place[:, rows], end[:, None]], axis=1)
        turn = np.concatenate(
            [turn[:, rows], (turn[:, tip.parentJoint] @ tip.placement.rotation)[:, None]], axis=1
        )
        return place @ back.rotation.T + back.translation, back.rotation @ turn

    def ends(self, theta: Array) -> Array:
        """Positions (n, 3) of the tip in the base link, many times faster than its poses."""
        back = self.base.inverse()
        return np.asarray(self._end(*self._frames(theta)) @ back.rotation.T + back.translation)

    def _frames(self, theta: Array) -> tuple[Array, Array]:
        """Rotations (n, njoints, 3, 3) and positions (n, njoints, 3) of all joints in the model's root."""
        model, _, tree = self._with(0.0, True)
        q = self._whole(theta) + self.offset
        turn, place = np.empty((len(q), model.njoints, 3, 3)), np.empty((len(q), model.njoints, 3))
        frames(q, tree, turn, place)
        return turn, place

    def _end(self, turn: Array, place: Array) -> Array:
        """(n, 3): the tip in the model's root."""
        tip = self.model.frames[self.tip]
        return np.asarray(place[:, tip.parentJoint] + turn[:, tip.parentJoint] @ tip.placement.translation)

    def frames(self, theta: Array, ids: list[int]) -> list[Any]:
        """Poses (SE3) of frames in the model's root at joint angles (joints,)."""
        model, data, _ = self._with(0.0, True)
        library().framesForwardKinematics(model, data, (self._whole(theta[None]) + self.offset)[0])
        return [data.oMf[i].copy() for i in ids]

    def jacobian(self, theta: Array) -> Array:
        """(n, 6, joints) of the tip: m and rad along and about the base's axes per rad or m of each joint."""
        pin = library()
        model, data, _ = self._with(0.0, True)
        q, turn = self._whole(theta) + self.offset, np.kron(np.eye(2), self.base.rotation.T)
        out = np.empty((len(q), 6, model.nv))
        for k in range(len(q)):
            out[k] = pin.computeFrameJacobian(model, data, q[k], self.tip, pin.LOCAL_WORLD_ALIGNED)
        return np.asarray(turn @ out @ self.spread)

    def _whole(self, theta: Array) -> Array:
        """(n, nv) of the arm's (n, joints)."""
        return np.ascontiguousarray(np.asarray(theta, dtype=float) @ self.spread.T)

    def _with(self, payload: float, links: bool) -> tuple[Any, Any, Tree]:
        """The model with a mass at the tip, its scratch space, and its links."""
        key = (float(payload), links)
        if key not in self._loaded:
            pin = library()
            model = self.model.copy()
            if not links:
                for inertia in model.inertias:
                    inertia.setZero()
            frame = model.frames[self.tip]
            lump = pin.Inertia(float(payload), np.zeros(3), np.zeros((3, 3)))
            model.appendBodyToJoint(frame.parentJoint, lump, frame.placement)
            if len(self._loaded) >= KEPT:
                self._loaded.clear()
            self._loaded[key] = model, model.createData(), tree_of(model)
        return self._loaded[key]


def across(ways: Array) -> Array:
    """(n, 2, 3) unit vectors across unit vectors (n, 3) and each other; 0 where there is no direction."""
    aside = np.eye(3)[np.argmin(np.abs(ways), axis=1)]
    first = np.cross(ways, aside)
    size = np.linalg.norm(first, axis=1, keepdims=True)
    first = np.divide(first, size, out=np.zeros_like(first), where=size > 0.0)
    return np.stack([first, np.cross(ways, first)], axis=1)
