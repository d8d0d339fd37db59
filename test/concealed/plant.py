"""The whole arm: setpoints in, gearbox angle, joint angle and tip out, with hidden physics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from test.concealed.behind import LOADED, behind, sensed
from test.concealed.drive import driven
from test.concealed.friction import slid
from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT, STEP, Array, load, tip
from test.concealed.scene import Scene
from test.concealed.servo import run_servo

Effects: TypeAlias = tuple[Hidden, ...]
_SEES_THE_ARM = (*LOADED, "joint_coupling", "load_dependent_friction")


@dataclass(frozen=True)
class Motion:
    """What really happens at 2 ms: t (n,), the rest (n, 5); ``theta`` is what an ideal joint sensor shows."""

    t: Array
    phi: Array
    v: Array
    theta: Array
    true_theta: Array
    tau: Array
    tip: Array


def payload_of(hidden: Effects) -> float:
    """Mass at the tip, kg: that of the effect of load which brings one."""
    return max((float(h.parameters.get("payload", 0.0)) for h in hidden), default=0.0)


def run_wire(hidden: Effects, phi: Array, v: Array, start: Array | None = None) -> tuple[Array, Scene]:
    """True joint angle for a gearbox motion (n, 5) at 2 ms, and the scene that it was worked out in.

    Load and coupling depend on the joint angles themselves; the circle is closed by iteration, each round of
    which shrinks the error to about a hundredth.
    """
    begin = np.zeros(COUNT) if start is None else start
    payload, t = payload_of(hidden), np.arange(len(phi), dtype=np.float64) * STEP
    theta = phi * 0.625
    rounds = 4 if any(h.effect in _SEES_THE_ARM for h in hidden) else 1
    for _ in range(rounds):
        at = Scene(t, phi, v, theta, load(theta, payload))
        theta = behind(hidden, at, slid(hidden, at, driven(hidden, at), begin))
    return theta, at


def bent_tip(hidden: Effects, theta: Array) -> Array:
    """Tip y, z, roll (n, 3) of the true joint angles, with what is wrong about the arm itself."""
    error, tilt, bend = np.zeros(COUNT), 0.0, 0.0
    for h in hidden:
        if h.effect == "link_length_error":
            error += h.column("length_error")
        elif h.effect == "base_tilt":
            tilt = float(h.parameters["angle"])
        elif h.effect == "x_link_bending":
            bend = float(h.parameters["gain"])
    leaning = theta.copy()
    leaning[:, 0] += tilt
    out = tip(leaning, error)
    out[:, 1] -= bend * np.sin(leaning.cumsum(axis=1)[:, -1]) ** 2
    return out


def run(hidden: Effects, setpoint: Array, start: Array | None = None) -> Motion:
    """The arm under setpoints (n, 5) at 100 Hz, from rest at the first of them."""
    phi, v = run_servo(hidden, setpoint, payload_of(hidden))
    return moved(hidden, phi, v, start)


def moved(hidden: Effects, phi: Array, v: Array, start: Array | None = None) -> Motion:
    """The same from a gearbox motion (n, 5) at 2 ms."""
    theta, at = run_wire(hidden, phi, v, start)
    tau = load(theta, payload_of(hidden))
    return Motion(at.t, phi, v, sensed(hidden, at, theta), theta, tau, bent_tip(hidden, theta))
