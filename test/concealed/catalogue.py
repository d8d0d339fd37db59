"""How each effect of the contract's table is drawn: joints, form, parameters, and what scales its strength."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from test.concealed.hidden import Hidden
from test.concealed.nominal import COMPLIANCE, COUNT, LINK, V_MAX, Array
from test.concealed.recipe import Look, Recipe, scaled

Draw = Callable[[np.random.Generator, tuple[int, ...], Look], Recipe]
ALL = tuple(range(COUNT))


def _log(rng: np.random.Generator, low: float, high: float, n: int | None = None) -> Any:
    return np.exp(rng.uniform(np.log(low), np.log(high), n))


def _sizes(rng: np.random.Generator, n: int) -> Array:
    """Unequal sizes of about one on n joints."""
    return rng.uniform(0.6, 1.5, n)


def _signed(rng: np.random.Generator, n: int) -> Array:
    return _sizes(rng, n) * rng.choice([-1.0, 1.0], n)


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _one_of(rng: np.random.Generator, *forms: str) -> str:
    return forms[int(rng.integers(len(forms)))]


def _ratio_error(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    base = Hidden("ratio_error", joints, "linear", {"relative": _signed(rng, len(joints))}, ("relative",))
    return scaled(base, ("relative",), 3e-3, 0.06)


def _transmission_ripple(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    n = len(joints)
    values = {"amplitude": _sizes(rng, n), "cycles_per_rev": _log(rng, 8.0, 60.0, n),
              "phase": rng.uniform(-np.pi, np.pi, n)}  # fmt: skip
    form = _one_of(rng, "sine", "sine", "two_harmonics")
    base = Hidden("transmission_ripple", joints, form, values, tuple(values))
    return scaled(base, ("amplitude",), 3e-4, 0.02)


def _joint_coupling(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    """One source; the joints that it pulls on lie farther out, but for one case in five."""
    source = int(rng.integers(COUNT))
    if rng.uniform() < 0.8:
        source = int(rng.integers(COUNT - 1))
        joints = tuple(j for j in joints if j > source) or (int(rng.integers(source + 1, COUNT)),)
    joints = tuple(j for j in joints if j != source) or ((source + 1) % COUNT,)
    values = {"gain": _signed(rng, len(joints)), "source": source}
    base = Hidden("joint_coupling", joints, "linear", values, ("gain", "source"))
    return scaled(base, ("gain",), 3e-3, 0.08)


def _thermal_drift(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    if rng.uniform() < 0.4:
        base = Hidden("thermal_drift", joints, "straight", {"rate": _signed(rng, len(joints))}, ("rate",))
        return scaled(base, ("rate",), 1e-5, 3e-4)
    values = {"amplitude": _signed(rng, len(joints)), "time_constant": float(_log(rng, 8.0, 90.0))}
    base = Hidden("thermal_drift", joints, "exponential", values, ("amplitude", "time_constant"))
    return scaled(base, ("amplitude",), 1e-3, 0.03)


def _wire_slip(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    joints = joints[:1]
    seconds = look.motion.t[-1]
    values = {"onset": rng.uniform(0.15, 0.85, len(joints)) * seconds, "step": _signed(rng, len(joints))}
    base = Hidden("wire_slip", joints, _one_of(rng, "jump", "jump", "sliding"), values, ("onset", "step"))
    return scaled(base, ("step",), 1e-3, 0.02)


def _backlash(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    base = Hidden("backlash", joints, "play", {"half_width": _sizes(rng, len(joints))}, ("half_width",))
    return scaled(base, ("half_width",), 1e-3, 0.02)


def _tension_error(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    slack = rng.uniform() < 0.3

    def make(size: float) -> Hidden:
        factor = 1 - 0.95 * size / 12 if slack else 1 + size
        return Hidden("tension_error", ALL, "scaled", {"factor": factor}, ("factor",))

    return Recipe(make, 1.0, 12.0)


def _load_dependent_friction(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    form = _one_of(rng, "straight", "straight", "smooth")
    base = Hidden("load_dependent_friction", joints, form, {"gain": _sizes(rng, len(joints))}, ("gain",))
    return scaled(base, ("gain",), 0.02, 0.3)


def _stribeck_friction(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    values = {"amplitude": _sizes(rng, len(joints)), "velocity": _log(rng, 0.01, 0.12, len(joints))}
    form = _one_of(rng, "exponential", "gaussian", "rational")
    same = ("amplitude", "velocity") if form == "exponential" else ("amplitude",)
    return scaled(Hidden("stribeck_friction", joints, form, values, same), ("amplitude",), 1e-3, 0.02)


def _friction_wear(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    form = _one_of(rng, "straight", "straight", "running_in", "travel")
    same = ("rate",) if form == "straight" else ()
    base = Hidden("friction_wear", joints, form, {"rate": _sizes(rng, len(joints))}, same)
    return scaled(base, ("rate",), 1e-5, 3e-4)


def _presliding_hysteresis(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    form = _one_of(rng, "uniform", "exponential", "maxwell", "bouc_wen_1", "bouc_wen_2", "dahl")
    extra: dict[str, Any] = {}
    if form in ("uniform", "exponential", "maxwell"):
        many = 5 if form == "maxwell" else 24
        place = (np.arange(many) + 0.5) / many if form != "maxwell" else np.linspace(0.0, 1.0, many)
        weight = np.ones(many) if form == "uniform" else np.exp(-2.5 * place)
        weight = rng.uniform(0.5, 1.5, many) if form == "maxwell" else weight
        extra = {"place": place.tolist(), "weight": (weight / weight.sum()).tolist()}
    same = ("width",) if form == "uniform" else ()
    base = Hidden("presliding_hysteresis", joints, form, {"width": _sizes(rng, len(joints))}, same, extra)
    return scaled(base, ("width",), 1e-3, 0.02)


def _load_elasticity(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    """Either the wire as it is, on all joints, under a payload; or some share of it on some joints."""
    if rng.uniform() < 0.4:
        values = {"compliance": COMPLIANCE, "payload": float(_log(rng, 0.01, 0.12))}
        whole = Hidden("load_elasticity", ALL, "wire", values, ("compliance", "payload"))
        return Recipe(lambda size: whole, 1.0, 1.0, fixed=True)
    payload = float(_log(rng, 0.01, 0.12)) if rng.uniform() < 0.5 else 0.0
    values = {"compliance": COMPLIANCE[list(joints)] * _sizes(rng, len(joints)), "payload": payload}
    base = Hidden("load_elasticity", joints, "scaled", values, ("compliance",))
    return scaled(base, ("compliance",), 0.3, 3.0)


def _pull(look: Look, joints: tuple[int, ...], payload: float) -> Array:
    """Largest load on the joints with a payload (its part taken as for the arm's own weight at the tip)."""
    more = payload * 9.81 * LINK * np.arange(COUNT, 0, -1)[list(joints)] * 0.3
    return look.top("tau", joints) + more


def _soft_wire(rng: np.random.Generator, joints: tuple[int, ...]) -> tuple[tuple[int, ...], float]:
    return (ALL if rng.uniform() < 0.5 else joints), float(_log(rng, 0.01, 0.12))


def _wire_slack(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    joints, payload = _soft_wire(rng, joints)
    threshold = rng.uniform(0.2, 0.6, len(joints)) * _pull(look, joints, payload)
    values = {"compliance": COMPLIANCE[list(joints)], "threshold": threshold, "payload": payload}
    slack = Hidden("wire_slack", joints, _one_of(rng, "kinked", "smooth"), values, ("threshold", "payload"))
    return Recipe(lambda size: slack, 1.0, 1.0, fixed=True)


def _wire_stiffening(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    joints, payload = _soft_wire(rng, joints)
    moment = rng.uniform(0.2, 1.0, len(joints)) * _pull(look, joints, payload)
    values = {"compliance": COMPLIANCE[list(joints)], "moment": moment, "payload": payload}
    form = _one_of(rng, "logarithm", "arctangent", "hyperbolic")
    stiff = Hidden("wire_stiffening", joints, form, values, ("payload",))
    return Recipe(lambda size: stiff, 1.0, 1.0, fixed=True)


def _viscoelastic_creep(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    values = {"gain": _sizes(rng, len(joints)), "time_constant": float(_log(rng, 1.5, 20.0))}
    if rng.uniform() < 0.4:
        slower = values["time_constant"] * rng.uniform(3.0, 8.0)
        extra = {"second_time_constant": float(slower), "share": float(rng.uniform(0.4, 0.7))}
        base = Hidden("viscoelastic_creep", joints, "two_modes", values, (), extra)
    else:
        base = Hidden("viscoelastic_creep", joints, "one_mode", values, ("gain", "time_constant"))
    return scaled(base, ("gain",), 5e-3, 0.1)


def _viscous_lag(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    form = _one_of(rng, "first_order", "first_order", "shift")
    base = Hidden("viscous_lag", joints, form, {"time_constant": _sizes(rng, len(joints))}, ("time_constant",))
    return scaled(base, ("time_constant",), 3e-3, 0.08)


def _link_resonance(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    """Stronger with the square of the period."""
    spread, damping = rng.uniform(0.8, 1.3, len(joints)), float(_log(rng, 0.03, 0.2))
    form = _one_of(rng, "absolute_damping", "absolute_damping", "relative_damping")

    def make(size: float) -> Hidden:
        values = {"frequency": 30.0 * spread / np.sqrt(size), "damping": damping}
        return Hidden("link_resonance", joints, form, values, ("frequency", "damping"))

    return Recipe(make, 20.0, 120.0)


def _hard_stop(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    joints, side = joints[:1], _one_of(rng, "upper", "lower")
    give = float(rng.uniform(0.02, 0.1)) if rng.uniform() < 0.4 else 0.0
    sign = 1.0 if side == "upper" else -1.0
    reach = float((sign * look.motion.theta[:, joints[0]]).max())

    def make(size: float) -> Hidden:
        form = "compliant" if give else "hard"
        values = {side: np.array([sign * (reach - size)])}
        return Hidden("hard_stop", joints, form, values, (side,) if not give else (), {"give": give})

    return Recipe(make, 0.01, max(0.9 * reach, 1e-3))


def _shared(effect: str, form: str, name: str, sign: float, start: float, limit: float) -> Recipe:
    return scaled(Hidden(effect, ALL, form, {name: sign}, (name,)), (name,), start, limit)


def _sensor_delay(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    return _shared("sensor_delay", "pure", "delay", 1.0, 5e-3, 0.06)


def _zero_offset(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    base = Hidden("zero_offset", joints, "constant", {"offset": _signed(rng, len(joints))}, ("offset",))
    return scaled(base, ("offset",), 1e-3, 0.02)


def _servo_delay(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    return _shared("servo_delay", "pure", "delay", 1.0, 5e-3, 0.06)


def _servo_bandwidth(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    return _shared("servo_bandwidth", "gain", "relative", _sign(rng), 0.05, 0.7)


def _velocity_saturation(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    fastest = min(V_MAX, float(look.top("v", ALL).max()))

    def make(size: float) -> Hidden:
        return Hidden("velocity_saturation", ALL, "clip", {"v_max": fastest * (1 - size)}, ("v_max",))

    return Recipe(make, 0.1, 0.7)


def _load_droop(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    return _shared("load_droop", "straight", "gain", _sign(rng), 0.01, 0.3)


def _cogging(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    phase = float(rng.uniform(-np.pi, np.pi)) if rng.uniform() < 0.5 else 0.0
    values = {"amplitude": 1.0, "cycles_per_rev": float(rng.integers(8, 61)), "phase": phase}
    base = Hidden("cogging", ALL, "sine", values, ("amplitude", "cycles_per_rev"))
    return scaled(base, ("amplitude",), 3e-4, 0.02)


def _link_length_error(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    joints = joints[:2]
    values = {"length_error": _signed(rng, len(joints))}
    base = Hidden("link_length_error", joints, "straight", values, ("length_error",))
    return scaled(base, ("length_error",), 3e-4, 5e-3)


def _base_tilt(rng: np.random.Generator, joints: tuple[int, ...], look: Look) -> Recipe:
    return _shared("base_tilt", "rigid", "angle", _sign(rng), 1e-3, 0.05)


CATALOGUE: dict[str, Draw] = {
    name.removeprefix("_"): draw
    for name, draw in list(globals().items())
    if name in {
        "_ratio_error", "_transmission_ripple", "_joint_coupling", "_thermal_drift", "_wire_slip", "_backlash",
        "_tension_error", "_load_dependent_friction", "_stribeck_friction", "_friction_wear",
        "_presliding_hysteresis", "_load_elasticity", "_wire_slack", "_wire_stiffening", "_viscoelastic_creep",
        "_viscous_lag", "_link_resonance", "_hard_stop", "_sensor_delay", "_zero_offset", "_servo_delay",
        "_servo_bandwidth", "_velocity_saturation", "_load_droop", "_cogging", "_link_length_error", "_base_tilt",
    }
}  # fmt: skip
