"""A joint with play, for motors without a position loop."""

from __future__ import annotations

from typing import Any

import numpy as np

BEARING = 1.5  # times the largest weight's moment: what a bearing rubs so that a link stays within its play
LEAST = 1e-3  # N m
POSTURES = 200  # in which weight is looked at


def add_play(mujoco: Any, spec: Any, joint: str, half_width: float) -> float:
    """Put a free joint behind a driven one, and a tendon over both whose friction [N m] holds the link; what
    it rubs.
    """
    own = spec.joint(joint)
    rub = max(BEARING * weight(mujoco, spec, joint), LEAST)
    own.parent.add_joint(
        name=f"{joint}_backlash", type=own.type, axis=own.axis, pos=own.pos, limited=True,
        range=[-half_width, half_width], armature=float(own.armature),
    )  # fmt: skip
    link = spec.add_tendon(name=f"{joint}_link", frictionloss=rub)
    link.wrap_joint(joint, 1.0)
    link.wrap_joint(f"{joint}_backlash", 1.0)
    return rub


def weight(mujoco: Any, spec: Any, joint: str) -> float:
    """The largest moment of weight on a joint that random postures show [N m]."""
    model = spec.compile()
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    ends = np.where(model.jnt_limited[:, None] > 0, model.jnt_range, [-np.pi, np.pi])
    turning = model.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE)
    place, most = int(model.joint(joint).dofadr[0]), 0.0
    for _ in range(POSTURES):
        data.qpos[model.jnt_qposadr[turning]] = rng.uniform(*ends[turning].T)
        mujoco.mj_forward(model, data)
        most = max(most, abs(float(data.qfrc_bias[place])))
    return most
