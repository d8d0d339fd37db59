"""An arm in MuJoCo that has more than its model knows: rotors, friction, another last link."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from trunk_ros.arm.description import Description
from trunk_ros.compiled import Array
from trunk_ros.export.mjcf_file import STIFF
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

mujoco = pytest.importorskip("mujoco")

JOINTS = ("waist", "shoulder", "elbow")
LINK = """<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>
<inertia ixx="{turn}" iyy="{turn}" izz="{turn}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{place}"/><axis xyz="{axis}"/><limit lower="-2" upper="2" velocity="9" effort="99"/></joint>"""
PLACES = ("0 0 0.1", "0 0 0.1", "0 0 0.3")
MASS, CENTRE, TURN = (2.0, 1.5, 0.8), ("0 0 0.05", "0 0 0.15", "0 0 0.1"), (0.02, 0.012, 0.004)
FRICTION, DAMPING = np.array([0.6, 0.8, 0.3]), np.array([0.4, 0.5, 0.2])
OFFSET = np.array([0.2, -0.1, 0.05])  # N m that the torque sensors are off
ARMATURE = np.array([0.15, 0.2, 0.06])
RATIO = np.array([0.5, -0.25, 1.0])
HIDDEN_MASS, HIDDEN_CENTRE = 1.1, (0.02, -0.015, 0.14)
RATE, STEP = 200.0, 5e-4


def urdf(flat: bool = False) -> str:
    """Three links that move in space, or, ``flat``, about upright axes."""
    axes = ["0 0 1"] * 3 if flat else ["0 0 1", "1 0 0", "1 0 0"]
    places = ["0 0 0.1", "0 0.3 0", "0 0.3 0"] if flat else PLACES
    links = [LINK.format(name=f"link_{k}", centre=CENTRE[k], mass=MASS[k], turn=TURN[k]) for k in range(3)]
    joints = [
        JOINT.format(
            name=name,
            parent=("base", "link_0", "link_1")[k],
            child=f"link_{k}",
            place=places[k],
            axis=axes[k],
        )
        for k, name in enumerate(JOINTS)
    ]
    tip = '<link name="tip"/><joint name="end" type="fixed"><parent link="link_2"/><child link="tip"/>'
    tip += '<origin xyz="0 0 0.25"/></joint>'
    return f'<robot name="arm"><link name="base"/>{"".join(links + joints)}{tip}</robot>'


def model_of(flat: bool = False) -> Model:
    """What is believed of it."""
    known = load_model("direct").with_urdf(Description(urdf(flat)).text, JOINTS)
    return replace(known, arm=replace(known.arm, ratio=RATIO))


def truth(flat: bool = False) -> Any:
    """MuJoCo's model of the arm as it is."""
    spec = mujoco.MjSpec.from_string(urdf(flat))
    spec.option.timestep, spec.option.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    last = spec.body("link_2")
    last.mass, last.ipos, last.explicitinertial = HIDDEN_MASS, HIDDEN_CENTRE, True
    for k, name in enumerate(JOINTS):
        joint = spec.joint(name)
        joint.armature, joint.frictionloss = ARMATURE[k], FRICTION[k]
        joint.solref_friction, joint.solimp_friction = [2.0 * STEP, 1.0], list(STIFF)
        joint.damping = np.array([DAMPING[k], 0.0, 0.0]) if np.ndim(joint.damping) else DAMPING[k]
        joint.range, joint.limited = [-9.0, 9.0], False
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gainprm[0] = 1.0
    return spec.compile()


def wanted(stamp: Array, seed: int, speed: float) -> Array:
    """Angles (n, 3) of sums of sines."""
    rng = np.random.default_rng(seed)
    rates, phases = speed * rng.uniform(0.15, 1.1, (5, 3)), rng.uniform(0.0, 6.0, (5, 3))
    sizes = rng.uniform(0.1, 0.3, (5, 3))
    turn = 2 * np.pi * rates[None] * stamp[:, None, None] + phases
    rise = np.clip(stamp / 2.0, 0.0, 1.0)[:, None]
    return np.asarray(rise**2 * (sizes * np.sin(turn)).sum(axis=1))


def recorded(
    seconds: float = 60.0, seed: int = 0, speed: float = 1.0, flat: bool = False, noise: float = 1.0
) -> Recording:
    """A run of it under a stiff controller: motors' angles and torque with noise and an offset."""
    model = truth(flat)
    data, rng = mujoco.MjData(model), np.random.default_rng(seed + 100)
    per = round(1.0 / (RATE * STEP))
    stamp = np.arange(int(seconds * RATE)) / RATE
    fine = np.arange(len(stamp) * per) * STEP
    aim = wanted(fine, seed, speed)
    rate = np.gradient(aim, STEP, axis=0)
    angle, torque = np.empty((len(stamp), 3)), np.empty((len(stamp), 3))
    data.qpos[:] = aim[0]
    for k in range(len(fine)):
        data.ctrl[:] = 2000.0 * (aim[k] - data.qpos) + 60.0 * (rate[k] - data.qvel)
        if k % per == 0:
            angle[k // per] = data.qpos
        mujoco.mj_step(model, data)
        if k % per == 0:
            torque[k // per] = data.actuator_force
    angle += noise * 5e-5 * rng.normal(size=angle.shape)
    torque += noise * 0.05 * rng.normal(size=torque.shape) + OFFSET
    motors = JointSeries(stamp, JOINTS, angle / RATIO, None, torque * RATIO)
    series = {"gearbox_states": motors, "joint_states": JointSeries(stamp, JOINTS, angle)}
    return Recording(f"run{seed}", 10**18, float(stamp[-1]), series)
