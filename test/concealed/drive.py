"""Physics ahead of the play: what changes u = r phi. Each gives what is added to u, (n, 5) rad."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from test.concealed.hidden import Hidden
from test.concealed.nominal import RATIO, Array
from test.concealed.scene import Scene


def _ratio_error(h: Hidden, at: Scene) -> Array:
    return RATIO * at.phi * h.column("relative")


def _transmission_ripple(h: Hidden, at: Scene) -> Array:
    """An eccentric wheel; in its second form with an oval part."""
    turn = at.phi * h.column("cycles_per_rev") + h.column("phase")
    oval = 0.25 * np.sin(2 * turn + 1.0) if h.form == "two_harmonics" else 0.0
    return h.column("amplitude") * (np.sin(turn) + oval)


def _joint_coupling(h: Hidden, at: Scene) -> Array:
    out: Array = at.theta[:, [int(h.parameters["source"])]] * h.column("gain")
    return out


def _thermal_drift(h: Hidden, at: Scene) -> Array:
    t = at.t[:, None]
    if h.form == "straight":
        return t * h.column("rate")
    out: Array = -h.column("amplitude") * np.expm1(-t / h.parameters["time_constant"])
    return out


def _wire_slip(h: Hidden, at: Scene) -> Array:
    since = at.t[:, None] - h.column("onset")
    took = 0.08 if h.form == "sliding" else 1e-6
    return h.column("step") * np.clip(since / took, 0.0, 1.0)


def _gain_wear(h: Hidden, at: Scene) -> Array:
    return RATIO * at.phi * at.t[:, None] * h.column("rate")


def _cubic(h: Hidden, at: Scene) -> Array:
    return h.column("gain") * (RATIO * at.phi) ** 3


def _quadratic(h: Hidden, at: Scene) -> Array:
    return h.column("gain") * (RATIO * at.phi) ** 2


def _intermittent(h: Hidden, at: Scene) -> Array:
    """The zero jumps off and back several times."""
    off = np.zeros(at.t.size)
    for first, last in zip(h.parameters["first"], h.parameters["last"], strict=True):
        off[(at.t >= first) & (at.t < last)] = 1.0
    return off[:, None] * h.column("step")


def _breathing(h: Hidden, at: Scene) -> Array:
    wave = np.sin(2 * np.pi * at.t / h.parameters["period"] + h.parameters["phase"])
    out: Array = wave[:, None] * h.column("amplitude")
    return out


DRIVE: dict[str, Callable[[Hidden, Scene], Array]] = {
    "ratio_error": _ratio_error, "transmission_ripple": _transmission_ripple,
    "joint_coupling": _joint_coupling, "thermal_drift": _thermal_drift, "wire_slip": _wire_slip,
    "x_gain_wear": _gain_wear, "x_cubic": _cubic, "x_quadratic": _quadratic,
    "x_intermittent": _intermittent, "x_breathing": _breathing,
}  # fmt: skip


def driven(hidden: tuple[Hidden, ...], at: Scene) -> Array:
    """u = r phi and all that is added to it, (n, 5) rad."""
    u = RATIO * at.phi
    for h in hidden:
        if h.effect in DRIVE:
            u = u + DRIVE[h.effect](h, at)
    return u
