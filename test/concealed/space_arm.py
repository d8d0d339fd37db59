"""Arms with axes in space, in MuJoCo: built otherwise than their URDF says, with wires that give way."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
URDFS = {path.stem: path.read_text() for path in sorted((Path(__file__).parent / "arms").glob("*.urdf"))}
PASSES = 12  # of a joint that sags under a load that its sag changes
OPTIONS = '<mujoco><compiler fusestatic="false" balanceinertia="true"/></mujoco>'


@dataclass
class Built:
    """How an arm differs from its URDF; of joints in rad, m, rad/(N m), of frames in m and rad."""

    ratio: Array
    """(joints, motors): joint angle per motor angle less what the model has."""
    half_width: Array
    """(joints,): of the play."""
    friction: Array
    """(joints,): half-width per moment."""
    compliance: Array
    """(joints,): of the wire."""
    zero: Array
    """(joints,): reading less angle."""
    moved: dict[str, tuple[Array, Array]] = field(default_factory=dict)
    """By link: shift and turn of its place on the link before it, in the axes of that link."""
    payload: float = 0.0


def nothing(joints: int) -> Built:
    """An arm as its URDF says."""
    none = np.zeros(joints)
    return Built(np.zeros((joints, joints)), none, none.copy(), none.copy(), none.copy())


class Plant:
    """One arm: motor angles in, joint angles and poses of the tip out."""

    def __init__(self, name: str, built: Built, turns: Array):
        spec = mujoco.MjSpec.from_string(URDFS[name].replace("<link", OPTIONS + "\n<link", 1))
        for body in spec.bodies:
            if body.name in built.moved:
                _move(body, *built.moved[body.name])
        tip = spec.body("tool0")
        if built.payload:
            tip.mass, tip.inertia, tip.ipos = built.payload, [1e-9] * 3, [0.0, 0.0, 0.0]
            tip.explicitinertial = True
        self.built, self.turns = built, turns + built.ratio
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.joints = [self.model.joint(j).name for j in range(self.model.njnt)]
        self.limits = np.array(self.model.jnt_range)
        self._tip = self.model.body("tool0").id

    def load(self, theta: Array) -> Array:
        """Moment of the weight (n, joints), positive where it tends to increase the angle."""
        out = np.empty_like(theta)
        for k, q in enumerate(theta):
            self.data.qpos[:], self.data.qvel[:] = q, 0.0
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)
            mujoco.mj_crb(self.model, self.data)
            mujoco.mj_comVel(self.model, self.data)
            mujoco.mj_rne(self.model, self.data, 0, self.data.qfrc_bias)
            out[k] = -self.data.qfrc_bias
        return out

    def joints_of(self, motors: Array) -> Array:
        """True joint angles (n, joints) under motor angles (n, motors): path, play, stretch."""
        path = motors @ self.turns.T
        theta = path
        for _ in range(PASSES if (self.built.compliance.any() or self.built.friction.any()) else 1):
            load = (
                self.load(theta) if self.built.compliance.any() or self.built.friction.any() else 0.0 * path
            )
            width = self.built.half_width + self.built.friction * np.abs(load)
            better = _play(path, width) + self.built.compliance * load
            theta, before = better, theta
            if np.abs(theta - before).max() < 1e-9:
                break
        return theta

    def tip(self, theta: Array) -> Array:
        """Poses (n, 7) in the base link: x, y, z, quaternion x, y, z, w."""
        out = np.empty((len(theta), 7))
        for k, q in enumerate(theta):
            self.data.qpos[:] = q
            mujoco.mj_kinematics(self.model, self.data)
            out[k, :3] = self.data.xpos[self._tip]
            out[k, 3:] = np.roll(self.data.xquat[self._tip], -1)
        return out


def _move(body: Any, shift: Array, turn: Array) -> None:
    body.pos = np.asarray(body.pos) + shift
    angle = float(np.linalg.norm(turn))
    if angle:
        quat, both = np.empty(4), np.empty(4)
        mujoco.mju_axisAngle2Quat(quat, turn / angle, angle)
        mujoco.mju_mulQuat(both, quat, np.asarray(body.quat, dtype=float))
        body.quat = both


def _play(path: Array, width: Array) -> Array:
    """Coulomb's friction as a rope of slack: the joint stands until it is pulled."""
    out, stands = np.empty_like(path), path[0].copy()
    for k, pulled in enumerate(path):
        stands = (
            stands + np.maximum(pulled - width[k] - stands, 0.0) - np.maximum(stands - pulled - width[k], 0.0)
        )
        out[k] = stands
    return out
