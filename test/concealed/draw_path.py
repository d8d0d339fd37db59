"""Draws of what changes the path of the wire or its zero, ahead of the friction."""

from __future__ import annotations

import numpy as np

from test.concealed.draws import Joints, Rng, drawn, logarithmic, one_of, signed, sizes
from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT
from test.concealed.recipe import Look, Recipe, scaled


@drawn
def ratio_error(rng: Rng, joints: Joints, look: Look) -> Recipe:
    base = Hidden("ratio_error", joints, "linear", {"relative": signed(rng, len(joints))}, ("relative",))
    return scaled(base, ("relative",), 3e-3, 0.06)


@drawn
def transmission_ripple(rng: Rng, joints: Joints, look: Look) -> Recipe:
    n = len(joints)
    values = {"amplitude": sizes(rng, n), "cycles_per_rev": logarithmic(rng, 8.0, 60.0, n),
              "phase": rng.uniform(-np.pi, np.pi, n)}  # fmt: skip
    form = one_of(rng, "sine", "sine", "two_harmonics")
    base = Hidden("transmission_ripple", joints, form, values, tuple(values))
    return scaled(base, ("amplitude",), 3e-4, 0.02)


@drawn
def joint_coupling(rng: Rng, joints: Joints, look: Look) -> Recipe:
    """One source; the joints that it pulls on lie farther out, but for one case in five."""
    source = int(rng.integers(COUNT))
    if rng.uniform() < 0.8:
        source = int(rng.integers(COUNT - 1))
        joints = tuple(j for j in joints if j > source) or (int(rng.integers(source + 1, COUNT)),)
    joints = tuple(j for j in joints if j != source) or ((source + 1) % COUNT,)
    values = {"gain": signed(rng, len(joints)), "source": source}
    base = Hidden("joint_coupling", joints, "linear", values, ("gain", "source"))
    return scaled(base, ("gain",), 3e-3, 0.08)


@drawn
def thermal_drift(rng: Rng, joints: Joints, look: Look) -> Recipe:
    if rng.uniform() < 0.4:
        base = Hidden("thermal_drift", joints, "straight", {"rate": signed(rng, len(joints))}, ("rate",))
        return scaled(base, ("rate",), 1e-5, 3e-4)
    values = {"amplitude": signed(rng, len(joints)), "time_constant": float(logarithmic(rng, 8.0, 90.0))}
    base = Hidden("thermal_drift", joints, "exponential", values, ("amplitude", "time_constant"))
    return scaled(base, ("amplitude",), 1e-3, 0.03)


@drawn
def wire_slip(rng: Rng, joints: Joints, look: Look) -> Recipe:
    joints = joints[:1]
    seconds = look.motion.t[-1]
    values = {"onset": rng.uniform(0.15, 0.85, len(joints)) * seconds, "step": signed(rng, len(joints))}
    base = Hidden("wire_slip", joints, one_of(rng, "jump", "jump", "sliding"), values, ("onset", "step"))
    return scaled(base, ("step",), 1e-3, 0.02)
