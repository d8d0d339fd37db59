"""A link that swings on its wire's spring, behind a position actuator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.export.mjcf_actuator import Drive

QUICKEST = 0.3  # rad of the swing in a time step, beyond which MuJoCo cannot follow it
DIFFERS = 0.03  # of the frequency: then it is worth a remark

HELD = "{}: its swing is not written: {} would hold it"
TOO_QUICK = "{}: its swing of {:.3g} Hz is not written: it is too quick for the time step"
OTHER_MASS = "{}: swings at {:.3g} Hz in this file, {:.3g} Hz with the model's masses: the file has others"
AT_REST = "{}: a filter of {:.3g} s has its loop's lag: begin with its actuator's `act` at the command"


@dataclass(frozen=True)
class Swing:
    """What became of a joint's swing."""

    hertz: float
    """0 where it is not written."""
    remarks: list[str]


def write_swing(
    mujoco: Any, spec: Any, joint: str, drive: Drive, damping: float, late: float, model_inertia: float,
    rubs: bool = False,
) -> Swing:  # fmt: skip
    """Let a joint swing on the stiffness of its drive with the damping ratio ``damping`` of the straight arm.

    The rotor lies before the spring and does not swing with the link: no armature. The loop's own lag on a
    ramp, ``late`` s, stays: what the swing is not late itself is a filter of the command.
    ``model_inertia``: kg m^2 that the model has at the joint. ``rubs``: friction holds the link in the model
    as well.
    """
    own, stiffness = spec.joint(joint), drive.stiffness
    if own.frictionloss > 0.0 and not rubs:
        return Swing(0.0, [HELD.format(joint, "friction")])
    inertia = straight_inertia(mujoco, spec, joint)
    omega = float(np.sqrt(stiffness / inertia))
    if omega * spec.option.timestep > QUICKEST:
        return Swing(0.0, [TOO_QUICK.format(joint, omega / (2.0 * np.pi))])
    own.armature = 0.0
    own.damping = 0.0 * np.array(own.damping) if np.ndim(own.damping) else 0.0
    rate = 2.0 * damping * float(np.sqrt(stiffness * inertia))
    drive.damp(rate)
    remarks = []
    meant = float(np.sqrt(stiffness / model_inertia))
    if abs(omega - meant) > DIFFERS * meant:
        remarks.append(OTHER_MASS.format(joint, omega / (2.0 * np.pi), meant / (2.0 * np.pi)))
    later = late - rate / stiffness
    if later > 0.0 and drive.filter(later):
        remarks.append(AT_REST.format(joint, later))
    return Swing(omega / (2.0 * np.pi), remarks)


def straight_inertia(mujoco: Any, spec: Any, joint: str) -> float:
    """What a joint turns with all joints at 0, rotor aside [kg m^2]."""
    model = spec.compile()
    data = mujoco.MjData(model)
    turning = model.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE)
    data.qpos[model.jnt_qposadr[turning]] = 0.0
    mujoco.mj_forward(model, data)
    place = int(model.joint(joint).dofadr[0])
    push, out = np.eye(model.nv)[place], np.zeros(model.nv)
    mujoco.mj_mulM(model, data, out, push)
    return float(out[place] - model.dof_armature[place])
