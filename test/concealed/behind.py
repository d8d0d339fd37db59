"""Physics behind the play, in the contract's order: load, creep, lag, resonance, stop, delay, offset."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from scipy.signal import cont2discrete, lfilter

from test.concealed.hidden import Hidden
from test.concealed.nominal import COUNT, RATIO, Array
from test.concealed.scene import Scene


def _filtered(x: Array, above: list[float], below: list[float], step: float) -> Array:
    """A linear system above/below in s, discretised exactly for ramps, at rest where x begins; x (n,)."""
    num, den, _ = cont2discrete((above, below), step, method="foh")
    out: Array = x[0] + lfilter(np.ravel(num), den, x - x[0])
    return out


def _load_elasticity(h: Hidden, at: Scene, x: Array) -> Array:
    return x + h.column("compliance") * at.tau


def _wire_slack(h: Hidden, at: Scene, x: Array) -> Array:
    """Past the threshold one wire of the pair hangs: half the stiffness, twice the compliance."""
    soft, threshold = h.column("compliance"), h.column("threshold", 1.0)
    over = np.abs(at.tau) - threshold
    if h.form == "smooth":
        round_ = 0.1 * threshold
        beyond = round_ * np.logaddexp(0.0, over / round_) - round_ * np.log1p(np.exp(-10.0))
    else:
        beyond = np.maximum(over, 0.0)
    out: Array = x + soft * (at.tau + np.sign(at.tau) * beyond)
    return out


def _wire_stiffening(h: Hidden, at: Scene, x: Array) -> Array:
    """Three softening laws of the deflection; in each the local compliance has halved at ``moment``."""
    soft, moment = h.column("compliance"), h.column("moment", 1.0)
    pull = np.abs(at.tau) / moment
    bent = {
        "logarithm": np.log1p(pull),
        "arctangent": np.arctan(pull),
        "hyperbolic": pull / (1 + (np.sqrt(2) - 1) * pull),
    }[h.form]
    out: Array = x + soft * moment * np.sign(at.tau) * bent
    return out


def _viscoelastic_creep(h: Hidden, at: Scene, x: Array) -> Array:
    out, gain = x.copy(), h.column("gain")
    modes = [(h.extra.get("share", 1.0), h.parameters["time_constant"])]
    if h.form == "two_modes":
        modes.append((1 - modes[0][0], h.extra["second_time_constant"]))
    for j in h.joints:
        for part, late in modes:
            out[:, j] -= gain[j] * part * _filtered(x[:, j], [1.0], [late, 1.0], at.step)
    return out


def _viscous_lag(h: Hidden, at: Scene, x: Array) -> Array:
    out, late = x.copy(), h.column("time_constant")
    for j in h.joints:
        if h.form == "shift":  # a lag of x by T dx/dt, without memory
            out[:, j] = x[:, j] - late[j] * np.gradient(x[:, j], at.step)
        else:
            out[:, j] = _filtered(x[:, j], [1.0], [late[j], 1.0], at.step)
    return out


def _link_resonance(h: Hidden, at: Scene, x: Array) -> Array:
    """A mass behind a spring, damped against the base or against the wire."""
    out = x.copy()
    for j, hertz in zip(h.joints, h.parameters["frequency"], strict=True):
        w = 2 * np.pi * float(hertz)
        drag = 2 * h.parameters["damping"] * w
        above = [drag, w * w] if h.form == "relative_damping" else [w * w]
        out[:, j] = _filtered(x[:, j], above, [1.0, drag, w * w], at.step)
    return out


def _hard_stop(h: Hidden, at: Scene, x: Array) -> Array:
    side = "upper" if "upper" in h.parameters else "lower"
    sign = 1.0 if side == "upper" else -1.0
    over = np.maximum(sign * (x - h.column(side, sign * 9.0)), 0.0)
    out: Array = x - sign * over * (1 - h.extra.get("give", 0.0))
    return out


def _bump(h: Hidden, at: Scene, x: Array) -> Array:
    near = (RATIO * at.phi - h.column("at")) / h.column("width", 1.0)
    return x + h.column("amplitude") * np.exp(-0.5 * near**2)


def _one_sided_lag(h: Hidden, at: Scene, x: Array) -> Array:
    return x - h.column("gain") * np.maximum(at.speed, 0.0)


def _centrifugal(h: Hidden, at: Scene, x: Array) -> Array:
    return x + h.column("gain") * at.speed**2


def _velocity_coupling(h: Hidden, at: Scene, x: Array) -> Array:
    out: Array = x + h.column("gain") * at.speed[:, [int(h.parameters["source"])]]
    return out


def _vibration(h: Hidden, at: Scene, x: Array) -> Array:
    wave = np.sin(2 * np.pi * h.parameters["frequency"] * at.t + h.parameters["phase"])
    out: Array = x + h.column("amplitude") * wave[:, None]
    return out


def _sensor_delay(h: Hidden, at: Scene, x: Array) -> Array:
    late = at.t - h.parameters["delay"]
    return np.stack([np.interp(late, at.t, x[:, j]) for j in range(COUNT)], axis=1)


def _zero_offset(h: Hidden, at: Scene, x: Array) -> Array:
    return x + h.column("offset")


Law: TypeAlias = Callable[[Hidden, Scene, Array], Array]
BEHIND: dict[str, Law] = {
    "load_elasticity": _load_elasticity, "wire_slack": _wire_slack, "wire_stiffening": _wire_stiffening,
    "viscoelastic_creep": _viscoelastic_creep, "viscous_lag": _viscous_lag, "link_resonance": _link_resonance,
    "x_bump": _bump, "x_one_sided_lag": _one_sided_lag, "x_centrifugal": _centrifugal,
    "x_velocity_coupling": _velocity_coupling, "x_vibration": _vibration, "hard_stop": _hard_stop,
    "zero_offset": _zero_offset,
}  # fmt: skip
SENSOR: dict[str, Law] = {"sensor_delay": _sensor_delay}
LOADED = ("load_elasticity", "wire_slack", "wire_stiffening")


def behind(hidden: tuple[Hidden, ...], at: Scene, x: Array) -> Array:
    """True joint angle from the angle behind the friction, (n, 5) rad."""
    return _through(BEHIND, hidden, at, x)


def sensed(hidden: tuple[Hidden, ...], at: Scene, x: Array) -> Array:
    """What an ideal joint sensor shows of the true joint angle, (n, 5) rad."""
    return _through(SENSOR, hidden, at, x)


def _through(table: dict[str, Law], hidden: tuple[Hidden, ...], at: Scene, x: Array) -> Array:
    for name, law in table.items():
        for h in hidden:
            if h.effect == name:
                x = law(h, at, x)
    return x
