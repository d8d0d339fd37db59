"""Draws of what the joint does behind the friction, and of its sensor."""

from __future__ import annotations

import numpy as np

from test.concealed.draws import Joints, Rng, drawn, logarithmic, one_of, shared, signed, sizes
from test.concealed.hidden import Hidden
from test.concealed.recipe import Look, Recipe, scaled


@drawn
def viscoelastic_creep(rng: Rng, joints: Joints, look: Look) -> Recipe:
    late = float(logarithmic(rng, 1.5, 20.0))
    values = {"gain": sizes(rng, len(joints)), "time_constant": late}
    if rng.uniform() < 0.4:
        slower = late * rng.uniform(3.0, 8.0)
        extra = {"second_time_constant": float(slower), "share": float(rng.uniform(0.4, 0.7))}
        base = Hidden("viscoelastic_creep", joints, "two_modes", values, (), extra)
    else:
        base = Hidden("viscoelastic_creep", joints, "one_mode", values, ("gain", "time_constant"))
    return scaled(base, ("gain",), 5e-3, 0.1)


@drawn
def viscous_lag(rng: Rng, joints: Joints, look: Look) -> Recipe:
    form = one_of(rng, "first_order", "first_order", "shift")
    base = Hidden("viscous_lag", joints, form, {"time_constant": sizes(rng, len(joints))}, ("time_constant",))
    return scaled(base, ("time_constant",), 3e-3, 0.08)


@drawn
def link_resonance(rng: Rng, joints: Joints, look: Look) -> Recipe:
    """Stronger with the square of the period."""
    spread, damping = rng.uniform(0.8, 1.3, len(joints)), float(logarithmic(rng, 0.03, 0.2))
    form = one_of(rng, "absolute_damping", "absolute_damping", "relative_damping")

    def make(size: float) -> Hidden:
        values = {"frequency": 30.0 * spread / np.sqrt(size), "damping": damping}
        return Hidden("link_resonance", joints, form, values, ("frequency", "damping"))

    return Recipe(make, 20.0, 120.0)


@drawn
def hard_stop(rng: Rng, joints: Joints, look: Look) -> Recipe:
    joints, side = joints[:1], one_of(rng, "upper", "lower")
    give = float(rng.uniform(0.02, 0.1)) if rng.uniform() < 0.4 else 0.0
    sign = 1.0 if side == "upper" else -1.0
    reach = float((sign * look.motion.theta[:, joints[0]]).max())

    def make(size: float) -> Hidden:
        form = "compliant" if give else "hard"
        values = {side: np.array([sign * (reach - size)])}
        return Hidden("hard_stop", joints, form, values, (side,) if not give else (), {"give": give})

    return Recipe(make, 0.01, max(0.9 * reach, 1e-3))


@drawn
def sensor_delay(rng: Rng, joints: Joints, look: Look) -> Recipe:
    return shared("sensor_delay", "pure", "delay", 1.0, 5e-3, 0.06)


@drawn
def zero_offset(rng: Rng, joints: Joints, look: Look) -> Recipe:
    base = Hidden("zero_offset", joints, "constant", {"offset": signed(rng, len(joints))}, ("offset",))
    return scaled(base, ("offset",), 1e-3, 0.02)
