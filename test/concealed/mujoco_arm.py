"""The arm in MuJoCo: wheels, pulleys with dry friction, links with mass, and tendons that hold them together.

From each wheel a stiff tendon goes to a pulley that rubs, from there a tendon to the joint. Nothing of the
play, of stretch or of swinging is put in as a formula: only stiffness, damping, masses, gravity and Coulomb
friction.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

from test.concealed.nominal import COMPLIANCE, COUNT, GRAVITY, HALF_WIDTH, LINK, MASS, RATIO, STEP, Array
from test.concealed.nominal import R_C as R

SUB = 2  # engine steps in one of 2 ms
TICK = STEP / SUB
STIFF = COMPLIANCE / 1000  # rad/(N m) of a wire that gives way to nothing
SETTLE = 1e-3  # s, damping over stiffness of a wire
ROTOR = 4e-6  # s², inertia over stiffness of a wheel on its motor
MOTOR = 1e8  # N m/rad of a motor that gives way to nothing
FRICTION = f'solreffriction="{2 * TICK} 1" solimpfriction="0.999 0.9999 0.001 0.5 2"'
LIMITS = f'solreflimit="{2 * TICK} 1" solimplimit="0.999 0.9999 0.0001 0.5 2"'

mujoco.set_mju_user_warning(lambda text: None)  # it would write a file where it runs; see `run_mujoco`


@dataclass(frozen=True)
class Build:
    """What one arm is made of. Arrays (5,), one entry per joint; the defaults are the nominal arm.

    compliance rad/(N m) of the wire at the joint; settle s, its damping over its stiffness; friction:
    factor of the pulleys' dry friction; gap rad, play in the wire to the pulley; wheel: factor of the
    wheel's radius; route (5, 5): how much of another joint's angle a wire takes up; drag N m s/rad at the
    joint; zero rad; stops (5, 2) rad; slack N m, load at which one wire of the pair hangs (inf: a single
    tendon that also pushes); length m; payload kg; tilt rad; light: links weigh the same, with so much less
    inertia; balanced: their weight is carried by something else.
    """

    compliance: Array = field(default_factory=lambda: STIFF.copy())
    settle: Array = field(default_factory=lambda: np.full(COUNT, SETTLE))
    friction: Array = field(default_factory=lambda: np.full(COUNT, 1.0))
    gap: Array = field(default_factory=lambda: np.full(COUNT, 0.0))
    wheel: Array = field(default_factory=lambda: np.full(COUNT, 1.0))
    route: Array = field(default_factory=lambda: np.zeros((COUNT, COUNT)))
    drag: Array = field(default_factory=lambda: np.full(COUNT, 0.0))
    zero: Array = field(default_factory=lambda: np.full(COUNT, 0.0))
    stops: Array = field(default_factory=lambda: np.tile([-9.0, 9.0], (COUNT, 1)))
    slack: Array = field(default_factory=lambda: np.full(COUNT, np.inf))
    length: Array = field(default_factory=lambda: np.full(COUNT, LINK))
    payload: float = 0.0
    tilt: float = 0.0
    light: float = 1.0
    balanced: bool = False


def _hub(b: Build, j: int) -> str:
    """The joint: its stops, its drag, and its hub's inertia, heavier where it has to bear a stop."""
    low, high = b.stops[j]
    held = min(-low, high) < 9.0
    light = 1e-6 / STIFF[j] if b.compliance[j] == STIFF[j] else 1e-7
    stop = f'limited="true" range="{low} {high}"' if held else ""
    return f'damping="{b.drag[j]}" armature="{1e-3 if held else light}" {stop}'


def _links(b: Build) -> str:
    """The chain of links from the base, each with its mass at the middle and the payload at the tip."""
    open_, close, carried = "", "", f'gravcomp="{int(b.balanced)}"'
    for j in range(COUNT):
        at = f'pos="0 0 {b.length[j - 1]}"' if j else f'euler="{b.tilt} 0 0"'
        open_ += (
            f'<body {at} {carried}><joint name="joint_{j}" type="hinge" axis="1 0 0" {_hub(b, j)}/>'
            f'<inertial pos="0 0 {LINK / 2}" mass="{MASS[j] / b.light}" diaginertia="1e-7 1e-7 1e-7"/>'
        )
        close += "</body>"
    mass = max(b.payload / b.light, 1e-9)
    tip = (
        f'<body pos="0 0 {b.length[-1]}" {carried}><site name="tip"/>'
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia="1e-9 1e-9 1e-9"/></body>'
    )
    return open_ + tip + close


def _turning(b: Build) -> str:
    """Wheels and pulleys: they turn about their middle."""
    out = ""
    for j in range(COUNT):
        hold = 1 / STIFF[j]
        rub = b.friction[j] * HALF_WIDTH[j] * hold
        for name, rotor, more in (
            ("wheel", MOTOR * ROTOR, ""),
            ("pulley", 1e-6 * hold, f'frictionloss="{rub}"'),
        ):
            out += (
                f'<body><joint name="{name}_{j}" type="hinge" axis="1 0 0" armature="{rotor}" {more}/>'
                '<inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/></body>'
            )
    return out


def _tendon(ends: dict[str, float], stiffness: float, settle: float, rest: str) -> str:
    joints = "".join(f'<joint joint="{name}" coef="{R * by}"/>' for name, by in ends.items())
    force = f'stiffness="{stiffness / R**2}" damping="{stiffness * settle / R**2}"'
    return f'<fixed {force} springlength="{rest}">{joints}</fixed>'


def _wires(b: Build) -> str:
    out = ""
    for j in range(COUNT):
        here = {f"pulley_{j}": 1.0, f"wheel_{j}": -RATIO * b.wheel[j]}
        here |= {f"joint_{s}": -b.route[j, s] for s in range(COUNT) if b.route[j, s]}
        rest = f"{R * (b.zero[j] - b.gap[j])} {R * (b.zero[j] + b.gap[j])}"
        out += _tendon(here, 1 / STIFF[j], SETTLE, rest)
        ends, hold = {f"joint_{j}": 1.0, f"pulley_{j}": -1.0}, 1 / b.compliance[j]
        if np.isinf(b.slack[j]):
            out += _tendon(ends, hold, b.settle[j], "0 0")
        else:  # two wires that can only pull, tightened against each other
            pull = R * b.slack[j] / hold
            for rest in (f"-1 {-pull}", f"{pull} 1"):
                out += _tendon(ends, hold / 2, b.settle[j], rest)
    return out


def _xml(b: Build) -> str:
    motors = "".join(
        f'<position joint="wheel_{j}" kp="{MOTOR}" kv="{MOTOR * SETTLE}"/>' for j in range(COUNT)
    )
    return (
        f'<mujoco><compiler angle="radian"/><option timestep="{TICK}" gravity="0 0 {-GRAVITY * b.light}" '
        'integrator="implicitfast" noslip_iterations="2"><flag contact="disable"/></option>'
        f"<default><joint {FRICTION} {LIMITS}/></default><worldbody>{_turning(b)}{_links(b)}</worldbody>"
        f"<tendon>{_wires(b)}</tendon><actuator>{motors}</actuator><sensor>"
        '<framepos objtype="site" objname="tip"/><framequat objtype="site" objname="tip"/></sensor></mujoco>'
    )


@dataclass(frozen=True)
class Ran:
    """At 2 ms: wheel angle rad, its speed rad/s, joint angle rad, (n, 5) each; tip (n, 3): y, z m, roll
    rad.
    """

    phi: Array
    v: Array
    theta: Array
    tip: Array


def _places(model: Any, name: str) -> list[int]:
    return [int(model.joint(f"{name}_{j}").qposadr[0]) for j in range(COUNT)]


def _asked(phi: Array, v: Array) -> Array:
    """Orders to the motors at the engine's steps: angle, and ahead of it what damping and inertia take."""
    steps = np.arange(len(phi) * SUB, dtype=np.float64) / SUB
    known = np.arange(len(phi), dtype=np.float64)
    angle, speed = (np.stack([np.interp(steps, known, c) for c in x.T], axis=1) for x in (phi, v))
    out: Array = angle + SETTLE * speed + ROTOR * np.gradient(speed, TICK, axis=0)
    return out


def _begin(model: Any, b: Build, phi: Array) -> Array:
    """State at rest with the wheels at phi (5,), everything behind them where stiff wires would have it."""
    at = np.zeros(model.nq)
    at[_places(model, "wheel")] = phi
    there = RATIO * b.wheel * phi + b.zero
    for _ in range(COUNT):  # a wire's path takes in other joints' angles
        there = RATIO * b.wheel * phi + b.zero + b.route @ there
    at[_places(model, "pulley")] = at[_places(model, "joint")] = np.clip(there, *b.stops.T)
    begin = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    begin[1 : 1 + model.nq] = at
    return begin


def run_mujoco(b: Build, phi: Array, v: Array) -> Ran:
    """The arm for what the servos ask of the wheels: angle rad and speed rad/s, (n, 5) at 2 ms.

    Raises RuntimeError where the engine warns or does not stay finite.
    """
    model = mujoco.MjModel.from_xml_string(_xml(b))
    begin = _begin(model, b, phi[0])
    data = mujoco.MjData(model)
    states, sensed = rollout.rollout(model, data, begin, _asked(phi, v)[None])
    if any(warning.number for warning in data.warning) or not np.isfinite(states).all():
        raise RuntimeError("the engine ran off: this build is too stiff for its steps")
    kept = np.concatenate([begin[None], states[0][SUB - 1 :: SUB][: len(phi) - 1]])
    q, u = kept[:, 1 : 1 + model.nq], kept[:, 1 + model.nq :]
    seen = sensed[0][SUB::SUB][: len(phi) - 1]  # sensors show the beginning of a step
    seen = np.concatenate([sensed[0][:1], seen, sensed[0][-1:]])[: len(phi)]
    tip = np.stack([seen[:, 1], seen[:, 2], 2 * np.arctan2(seen[:, 4], seen[:, 3])], axis=1)
    wheel = _places(model, "wheel")
    return Ran(q[:, wheel], u[:, wheel], q[:, _places(model, "joint")], tip)
