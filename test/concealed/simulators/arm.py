"""An arm in MuJoCo as its user simulates it, and as it is built: with second joints, springs and friction.

Nothing of a play, a loop or a sag is a formula here: a second joint has a range or a spring, a bearing rubs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np

from test.concealed.nominal import Array

JOINTS = ("shoulder", "elbow", "wrist")
LENGTH, MASS = (0.25, 0.20, 0.15), (0.5, 0.35, 0.2)  # m, kg
KP, KV = (2000.0, 1000.0, 400.0), (40.0, 20.0, 8.0)  # N m/rad, N m s/rad
ROTOR = 0.05  # kg m^2
STEP, TICK = 0.001, 0.01  # s: of the engine, and between two commands
EDGE = 'solreflimit="0.002 1" solimplimit="0.999 0.9999 0.0001 0.5 2"'
RUB = 'solreffriction="0.002 1" solimpfriction="0.999 0.9999 0.001 0.5 2"'
NEVER = np.full(len(JOINTS), np.inf)
NONE = np.zeros(len(JOINTS))


@dataclass(frozen=True)
class Real:
    """How the arm is built; arrays (3,). The defaults are what its user simulates.

    gap rad: to either side, between motor and link; soft rad/(N m): of a spring there instead; rub N m: of
    the link's bearing; ratio: relative error of the transmission; ripple rad, teeth, phase: of its angle;
    payload kg; late, shown_late s: of commands and of joint readings; upright: weight acts on the joints.
    """

    gap: Array = field(default_factory=lambda: NONE)
    soft: Array = field(default_factory=lambda: NONE)
    rub: Array = field(default_factory=lambda: NONE)
    ratio: Array = field(default_factory=lambda: NONE)
    ripple: Array = field(default_factory=lambda: NONE)
    teeth: float = 12.0
    phase: float = 0.0
    payload: float = 0.0
    late: float = 0.0
    shown_late: float = 0.0
    upright: bool = False


def xml(real: Real, own: bool = False) -> str:
    """The arm as MJCF; ``own``: as its user has it, one joint each."""
    bodies = ""
    for j in reversed(range(len(JOINTS))):
        at = f"0 0 {LENGTH[j - 1]}" if j else "0 0 0.1"
        second = "" if own or not (real.gap[j] or real.soft[j]) else _second(real, j)
        load = (
            f'<geom type="sphere" size="0.01" pos="0 0 {LENGTH[j]}" mass="{real.payload}"/>'
            if real.payload and j == len(JOINTS) - 1 and not own
            else ""
        )
        tip = f'<site name="tip" pos="0 0 {LENGTH[j]}"/>' if j == len(JOINTS) - 1 else ""
        bodies = (
            f'<body name="{JOINTS[j]}_link" pos="{at}"><joint name="{JOINTS[j]}" axis="1 0 0" '
            f'armature="{ROTOR}"/>{second}<geom type="box" size="0.01 0.01 {LENGTH[j] / 2}" '
            f'pos="0 0 {LENGTH[j] / 2}" mass="{MASS[j]}"/>{load}{tip}{bodies}</body>'
        )
    motors = "".join(
        f'<position name="{name}_servo" joint="{name}" kp="{kp}" kv="{kv}"/>'
        for name, kp, kv in zip(JOINTS, KP, KV, strict=True)
    )
    sensors = "".join(f'<jointpos name="{name}_encoder" joint="{name}"/>' for name in JOINTS)
    gravity = "0 0 -9.81" if real.upright else "-9.81 0 0"
    return (
        f'<mujoco model="arm"><compiler angle="radian"/><option timestep="{STEP}" gravity="{gravity}" '
        f'integrator="implicitfast"><flag contact="disable"/></option><worldbody>{bodies}</worldbody>'
        f"{'' if own else _bearings(real)}<actuator>{motors}</actuator><sensor>{sensors}</sensor></mujoco>"
    )


def _second(real: Real, j: int) -> str:
    """The joint between motor and link: it has play, or it is a spring."""
    if real.soft[j]:
        hold = 1.0 / real.soft[j]
        holds = f'stiffness="{hold}" damping="{0.01 * hold}"'
    else:
        holds = f'limited="true" range="{-real.gap[j]} {real.gap[j]}" {EDGE}'
    return f'<joint name="{JOINTS[j]}_beyond" axis="1 0 0" armature="0.001" {holds}/>'


def _bearings(real: Real) -> str:
    """Friction between each link and the one before it."""
    out = ""
    for j, name in enumerate(JOINTS):
        if real.rub[j]:
            beyond = f'<joint joint="{name}_beyond" coef="1"/>' if real.gap[j] or real.soft[j] else ""
            out += (
                f'<fixed name="{name}_bearing" frictionloss="{real.rub[j]}" {RUB}>'
                f'<joint joint="{name}" coef="1"/>{beyond}</fixed>'
            )
    return f"<tendon>{out}</tendon>" if out else ""


@dataclass(frozen=True)
class Ran:
    """At each tick before its command acts, (n, 3) rad: the motors' encoders, and what the joints show."""

    motor: Array
    joint: Array


def run(real: Real, commands: Array) -> Ran:
    """The arm under commands (n, 3) rad, one a tick, each held until the next."""
    model = mujoco.MjModel.from_xml_string(xml(real))
    data = mujoco.MjData(model)
    per = round(TICK / STEP)
    begin = geared(real, commands[0])
    places = [int(model.joint(name).qposadr[0]) for name in JOINTS]
    beyond = [
        int(model.joint(f"{name}_beyond").qposadr[0]) if real.gap[j] or real.soft[j] else -1
        for j, name in enumerate(JOINTS)
    ]
    data.qpos[places] = begin
    steps = len(commands) * per
    motor, link = np.empty((steps, len(JOINTS))), np.empty((steps, len(JOINTS)))
    for k in range(steps):
        asked = max(int(np.floor((k * STEP - real.late) / TICK + 1e-9)), 0)
        data.ctrl[:] = geared(real, commands[asked])
        motor[k] = data.qpos[places]
        link[k] = motor[k] + [data.qpos[at] if at >= 0 else 0.0 for at in beyond]
        mujoco.mj_step(model, data)
    late = np.maximum(np.arange(0, steps, per) - round(real.shown_late / STEP), 0)
    return Ran(encoder(real, motor[::per]), link[late])


def geared(real: Real, angle: Array) -> Array:
    """Where the transmission's output stands for motors at ``angle`` (..., 3)."""
    return np.asarray(angle * (1.0 + real.ratio) + real.ripple * np.sin(real.teeth * angle + real.phase))


def encoder(real: Real, out: Array) -> Array:
    """The motors' angle for outputs (n, 3)."""
    angle = out / (1.0 + real.ratio)
    for _ in range(20):
        angle = (out - real.ripple * np.sin(real.teeth * angle + real.phase)) / (1.0 + real.ratio)
    return np.asarray(angle)
