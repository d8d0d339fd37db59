"""Draws of what the servo and the arm itself may hide."""

from __future__ import annotations

import numpy as np

from test.concealed.draws import ALL, Joints, Rng, drawn, shared, sign, signed
from test.concealed.hidden import Hidden
from test.concealed.nominal import V_MAX
from test.concealed.recipe import Look, Recipe, scaled


@drawn
def servo_delay(rng: Rng, joints: Joints, look: Look) -> Recipe:
    return shared("servo_delay", "pure", "delay", 1.0, 5e-3, 0.06)


@drawn
def servo_bandwidth(rng: Rng, joints: Joints, look: Look) -> Recipe:
    return shared("servo_bandwidth", "gain", "relative", sign(rng), 0.05, 0.7)


@drawn
def velocity_saturation(rng: Rng, joints: Joints, look: Look) -> Recipe:
    fastest = min(V_MAX, float(look.top("v", ALL).max()))

    def make(size: float) -> Hidden:
        return Hidden("velocity_saturation", ALL, "clip", {"v_max": fastest * (1 - size)}, ("v_max",))

    return Recipe(make, 0.1, 0.7)


@drawn
def load_droop(rng: Rng, joints: Joints, look: Look) -> Recipe:
    return shared("load_droop", "straight", "gain", sign(rng), 0.01, 0.3)


@drawn
def cogging(rng: Rng, joints: Joints, look: Look) -> Recipe:
    phase = float(rng.uniform(-np.pi, np.pi)) if rng.uniform() < 0.5 else 0.0
    values = {"amplitude": 1.0, "cycles_per_rev": float(rng.integers(8, 61)), "phase": phase}
    base = Hidden("cogging", ALL, "sine", values, ("amplitude", "cycles_per_rev"))
    return scaled(base, ("amplitude",), 3e-4, 0.02)


@drawn
def link_length_error(rng: Rng, joints: Joints, look: Look) -> Recipe:
    joints = joints[:2]
    values = {"length_error": signed(rng, len(joints))}
    base = Hidden("link_length_error", joints, "straight", values, ("length_error",))
    return scaled(base, ("length_error",), 3e-4, 5e-3)


@drawn
def base_tilt(rng: Rng, joints: Joints, look: Look) -> Recipe:
    return shared("base_tilt", "rigid", "angle", sign(rng), 1e-3, 0.05)
