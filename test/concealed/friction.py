"""Physics in the play: its half-width, and the rounded loop in its place."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit

from test.concealed.hidden import Hidden
from test.concealed.nominal import HALF_WIDTH, RATIO, Array, play
from test.concealed.scene import Scene


def _backlash(h: Hidden, at: Scene) -> Array:
    return np.broadcast_to(h.column("half_width"), at.phi.shape)


def _tension_error(h: Hidden, at: Scene) -> Array:
    return np.broadcast_to(HALF_WIDTH * (h.column("factor", 1.0) - 1), at.phi.shape)


def _load_dependent_friction(h: Hidden, at: Scene) -> Array:
    pull = np.abs(at.tau)
    if h.form == "smooth":  # no kink where the load changes sign
        pull = np.hypot(at.tau, 0.01) - 0.01
    return h.column("gain") * pull


def _stribeck_friction(h: Hidden, at: Scene) -> Array:
    slow = np.abs(at.speed) / h.column("velocity", 1.0)
    shape = {
        "exponential": lambda x: np.exp(-x),
        "gaussian": lambda x: np.exp(-(x**2)),
        "rational": lambda x: 1 / (1 + x**2),
    }
    out: Array = h.column("amplitude") * shape[h.form](slow)
    return out


def _friction_wear(h: Hidden, at: Scene) -> Array:
    """Grows to rate times duration: straight, settling, or with the way slid (Archard)."""
    end, grown = at.t[-1], at.t[:, None] / at.t[-1]
    if h.form == "running_in":
        grown = np.expm1(-2 * grown) / np.expm1(-2)
    elif h.form == "travel":
        way = np.abs(at.speed).cumsum(axis=0)
        grown = way / np.maximum(way[-1], 1e-9)
    out: Array = h.column("rate") * end * grown
    return out


def _rough_patch(h: Hidden, at: Scene) -> Array:
    near = (RATIO * at.phi - h.column("at")) / h.column("width", 1.0)
    return h.column("amplitude") * np.exp(-0.5 * near**2)


WIDTH: dict[str, Callable[[Hidden, Scene], Array]] = {
    "backlash": _backlash, "tension_error": _tension_error, "stribeck_friction": _stribeck_friction,
    "load_dependent_friction": _load_dependent_friction, "friction_wear": _friction_wear,
    "x_rough_patch": _rough_patch,
}  # fmt: skip


@njit(cache=True)
def _bouc_wen(x: Array, top: float, power: int) -> Array:
    """Bouc-Wen restoring part z with beta = gamma = 1/2, which saturates at ``top``; power 1 or 2.

    Loading dz/dx = 1 - (|z|/top)^power is stepped by its solution, unloading dz/dx = 1 as it is.
    """
    z, out = 0.0, np.zeros_like(x)
    for k in range(1, x.size):
        dx = (x[k] - x[k - 1]) / top
        if dx * z < 0:
            z = min(max(z + dx, -1.0), 1.0)
        elif power == 1:
            way = 1.0 if dx > 0 else -1.0
            z = way + (z - way) * np.exp(-abs(dx))
        else:
            z = np.tanh(np.arctanh(min(max(z, -1 + 1e-12), 1 - 1e-12)) + dx)
        out[k] = z * top
    return out


@njit(cache=True)
def _dahl(x: Array, top: float) -> Array:
    """Dahl's solid friction, half as stiff as the wire so that a reversal begins with standing still."""
    z, out = 0.0, np.zeros_like(x)
    for k in range(1, x.size):
        dx = (x[k] - x[k - 1]) / top
        way = 1.0 if dx > 0 else -1.0
        z = way + (z - way) * np.exp(-0.5 * abs(dx))
        out[k] = z * top
    return out


def _spread(u: Array, width: Array, extra: float, weight: Array, place: Array, start: float) -> Array:
    """Plays side by side, of half-widths from the nominal to ``extra`` more (Prandtl-Ishlinskii)."""
    wide = width[:, None] + extra * place
    many = np.repeat(u[:, None], place.size, axis=1)
    out: Array = play(many, wide, wide, np.full(place.size, start)) @ weight
    return out


def _rounded(h: Hidden, n: int, u: Array, width: Array, start: float) -> Array:
    """The loop of joint number n of the effect: u (n,), half-width of the play (n,) -> angle (n,)."""
    extra = float(h.parameters["width"][n])
    if h.form in ("uniform", "exponential", "maxwell"):
        place, weight = (np.asarray(h.extra[key]) for key in ("place", "weight"))
        return _spread(u, width, extra, weight, place, start)
    sharp = play(u[:, None], width[:, None], width[:, None], np.array([start]))[:, 0]
    if h.form == "dahl":
        loop: Array = sharp - _dahl(sharp, extra / 2)
        return loop
    power = {"bouc_wen_1": 1, "bouc_wen_2": 2}[h.form]
    loop = sharp - _bouc_wen(sharp, extra / 2, power)
    return loop


def slid(hidden: tuple[Hidden, ...], at: Scene, u: Array, start: Array) -> Array:
    """Joint angle behind the friction, (n, 5) rad; start (5,) is where in its band it begins, -1 ... 1."""
    width = np.broadcast_to(HALF_WIDTH, u.shape).copy()
    for h in hidden:
        if h.effect in WIDTH:
            width += WIDTH[h.effect](h, at)
    width = np.maximum(width, 0.0)
    first = u[0] + start * width[0]
    out: Array = play(u, width, width, first)
    for h in hidden:
        if h.effect == "presliding_hysteresis":
            for n, j in enumerate(h.joints):
                out[:, j] = _rounded(h, n, u[:, j].copy(), width[:, j].copy(), float(first[j]))
    return out
