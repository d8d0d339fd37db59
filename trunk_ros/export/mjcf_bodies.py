"""The last link in an MJCF file."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.bodies.found import Bodies
from trunk_ros.export.last_link import OTHER_FRAME, TOO_LIGHT, Frame, own_part, turn_between

FROM_GEOMS = "{}: mass and centre of the last link: inertiafromgeom has masses come from geoms in this file"


def write_last_link(mujoco: Any, spec: Any, arm: Arm, bodies: Bodies) -> tuple[str, str]:
    """Set mass and centre of the body that the last joint moves; its name, or "" and why it cannot be."""
    own = spec.joint(bodies.last)
    if own is None or not arm.has_geometry:
        return "", OTHER_FRAME.format(bodies.last)
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        return "", FROM_GEOMS.format(bodies.last)
    link = own.parent
    link.name = link.name or f"{bodies.last}_link"
    model = spec.compile()
    data = mujoco.MjData(model)
    joints = [k for k, name in enumerate(arm.joints) if spec.joint(name) is not None and name != bodies.last]
    joints.append(arm.joints.index(bodies.last))
    ids = [model.joint(arm.joints[k]).id for k in joints]
    data.qpos[model.jnt_qposadr[ids]] = 0.0
    mujoco.mj_kinematics(model, data)
    body = model.body(link.name).id
    back, origin = data.xmat[body].reshape(3, 3).T, data.xpos[body]
    tips = [k for k in range(model.nsite) if "tip" in model.site(k).name]
    tip = (data.site_xpos[tips[0]] - origin) @ back.T if tips else np.full(3, np.nan)
    file = Frame(data.xaxis[ids] @ back.T, (data.xanchor[ids] - origin) @ back.T, tip)
    turn = turn_between(Frame.of(arm.body, joints), file)
    if turn is None:
        return "", OTHER_FRAME.format(bodies.last)
    rigid = [k for k in range(model.nbody) if model.body_weldid[k] == body and k != body]
    mass = model.body_mass[rigid]
    fixed = float(mass.sum()), mass @ ((data.xipos[rigid] - origin) @ back.T)
    part = own_part(bodies, turn, file.anchors[-1], fixed[0] + float(model.body_mass[body]), fixed)
    if part is None:
        return "", TOO_LIGHT.format(bodies.last)
    if not link.explicitinertial:
        link.inertia, link.iquat = model.body_inertia[body], model.body_iquat[body]
    link.mass, link.ipos, link.explicitinertial = part[0], part[1], True
    return str(link.name), ""
