"""Physics outside the contract's table: no name fits it."""

from __future__ import annotations

from typing import Any

import numpy as np

from test.concealed.draws import ALL, Draw, Joints, Rng, sign, signed, sizes
from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT
from test.concealed.recipe import Look, Recipe, scaled


def _bump(rng: Rng, joints: Joints, look: Look) -> Recipe:
    j = joints[:1]
    where = look.motion.theta[:, j[0]]
    at = float(rng.uniform(0.15, 0.85) * np.ptp(where) + where.min())
    values = {"amplitude": signed(rng, 1), "at": np.array([at]), "width": rng.uniform(0.02, 0.06, 1)}
    return scaled(Hidden("x_bump", j, "gaussian", values), ("amplitude",), 2e-3, 0.03)


def _rough_patch(rng: Rng, joints: Joints, look: Look) -> Recipe:
    recipe = _bump(rng, joints, look).make(1.0)
    values = {**recipe.parameters, "amplitude": sizes(rng, 1)}
    return scaled(Hidden("x_rough_patch", recipe.joints, "gaussian", values), ("amplitude",), 2e-3, 0.03)


def _plain(effect: str, name: str, start: float, limit: float, **more: Any) -> Draw:
    """An effect with one scaled parameter per joint."""

    def draw(rng: Rng, joints: Joints, look: Look) -> Recipe:
        joints = joints[:2]
        values = {name: signed(rng, len(joints)), **more}
        return scaled(Hidden(effect, joints, "plain", values), (name,), start, limit)

    return draw


def _one_sided_lag(rng: Rng, joints: Joints, look: Look) -> Recipe:
    base = Hidden("x_one_sided_lag", joints[:2], "plain", {"gain": sizes(rng, len(joints[:2]))})
    return scaled(base, ("gain",), 3e-3, 0.1)


def _intermittent(rng: Rng, joints: Joints, look: Look) -> Recipe:
    edges = np.sort(rng.uniform(0.08, 0.95, 2 * int(rng.integers(2, 5)))) * look.motion.t[-1]
    values = {"step": signed(rng, 1)}
    base = Hidden("x_intermittent", joints[:1], "jumps", values)
    recipe = scaled(base, ("step",), 1e-3, 0.02)

    def make(size: float) -> Hidden:
        done = recipe.make(size)
        done.parameters.update({"first": edges[::2], "last": edges[1::2]})
        return done

    return Recipe(make, recipe.start, recipe.limit)


def _velocity_coupling(rng: Rng, joints: Joints, look: Look) -> Recipe:
    j = joints[0]
    source = int((j + rng.integers(1, COUNT)) % COUNT)
    values = {"gain": signed(rng, 1), "source": source}
    return scaled(Hidden("x_velocity_coupling", (j,), "plain", values), ("gain",), 2e-3, 0.1)


def _vibration(rng: Rng, joints: Joints, look: Look) -> Recipe:
    values = {"amplitude": sizes(rng, len(joints)), "frequency": float(rng.uniform(1.0, 8.0)),
              "phase": float(rng.uniform(0, 2 * np.pi))}  # fmt: skip
    return scaled(Hidden("x_vibration", joints, "sine", values), ("amplitude",), 1e-3, 0.02)


def _breathing(rng: Rng, joints: Joints, look: Look) -> Recipe:
    values = {"amplitude": signed(rng, len(joints)), "period": float(rng.uniform(12.0, 40.0)),
              "phase": float(rng.uniform(0, 2 * np.pi))}  # fmt: skip
    return scaled(Hidden("x_breathing", joints, "sine", values), ("amplitude",), 1e-3, 0.02)


def _servo_dead_zone(rng: Rng, joints: Joints, look: Look) -> Recipe:
    return scaled(Hidden("x_servo_dead_zone", ALL, "plain", {"width": 1.0}), ("width",), 1e-3, 0.03)


def _link_bending(rng: Rng, joints: Joints, look: Look) -> Recipe:
    base = Hidden("x_link_bending", (COUNT - 1,), "plain", {"gain": sign(rng)})
    return scaled(base, ("gain",), 3e-4, 0.01)


STRANGE: dict[str, Draw] = {
    "x_bump": _bump,
    "x_gain_wear": _plain("x_gain_wear", "rate", 2e-4, 3e-3),
    "x_one_sided_lag": _one_sided_lag,
    "x_cubic": _plain("x_cubic", "gain", 0.1, 3.0),
    "x_quadratic": _plain("x_quadratic", "gain", 0.03, 1.0),
    "x_intermittent": _intermittent,
    "x_centrifugal": _plain("x_centrifugal", "gain", 3e-3, 0.3),
    "x_velocity_coupling": _velocity_coupling,
    "x_vibration": _vibration,
    "x_breathing": _breathing,
    "x_rough_patch": _rough_patch,
    "x_servo_dead_zone": _servo_dead_zone,
    "x_link_bending": _link_bending,
}
