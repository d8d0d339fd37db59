"""An arm as flat parameters: how it is declared, read and written."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.arm import GRAVITY, Arm, Wire
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError

ANY_JOINTS = "*"
ANY_ANGLE = 1e3  # rad: no limit


@dataclass(frozen=True)
class Declaration:
    """One ROS parameter: the type is that of ``default``; a one-element list stands for one value per joint."""

    name: str
    default: Any
    unit: str
    bounds: tuple[float, float] | None
    meaning: str


def _per_joint(name: str, unit: str, bounds: tuple[float, float], meaning: str) -> Declaration:
    return Declaration(name, [float("nan")], unit, bounds, meaning + ", per joint (nan: not given)")


WIRE_SCALARS = {
    "shaft_radius": ("m", "R_s, grooved wheel on the gearbox shaft"),
    "cylinder_radius": ("m", "R_c, joint cylinder"),
    "modulus": ("Pa", "E, Young's modulus of the wire"),
    "section": ("m^2", "A_s, cross section of the wire"),
    "pull_tension": ("N", "T_i, pull tension"),
}
WIRE_ARRAYS = {
    "mu1": ("1", "friction coefficient of the first arc"),
    "mu2": ("1", "friction coefficient of the second arc"),
    "a1": ("rad", "wrap angle of the first arc"),
    "a2": ("rad", "wrap angle of the second arc"),
    "length": ("m", "l, whole wire"),
    "length1": ("m", "l', stretch before the first arc"),
    "length2": ("m", "l'', stretch between the arcs"),
}
SERVO = {
    "kp": (20.0, "1/s", "position gain"),
    "tau_v": (0.02, "s", "time constant of the velocity loop"),
    "v_max": (1.5, "rad/s", "top speed of the gearbox shaft"),
    "counts_per_rev": (131072.0, "1", "encoder counts per turn of the gearbox shaft"),
}


def declared_arm() -> list[Declaration]:
    """The parameters of an arm, effects aside."""
    large = (0.0, 1e15)
    return [
        Declaration("arm.joints", [ANY_JOINTS], "", None, "joint names; '*' for whatever joints a recording has"),
        _per_joint("arm.lower", "rad", (-ANY_ANGLE, ANY_ANGLE), "lower joint limit"),
        _per_joint("arm.upper", "rad", (-ANY_ANGLE, ANY_ANGLE), "upper joint limit"),
        _per_joint("arm.link_length", "m", large, "length of the link that the joint turns"),
        _per_joint("arm.link_mass", "kg", large, "mass of the link, at its middle"),
        Declaration("arm.payload", 0.0, "kg", large, "mass at the tip"),
        Declaration("arm.gravity", GRAVITY, "m/s^2", large, "gravity, along -z"),
        _per_joint("wire.ratio", "1", (-1e6, 1e6), "joint angle per gearbox angle, in place of the radii"),
        _per_joint("wire.dead_band", "rad", large, "half-width of the nominal play, in place of the wire's formula"),
        _per_joint("wire.compliance", "rad/(N*m)", large, "nominal deflection per moment, in place of the wire's formula"),
        *(Declaration(f"wire.{name}", float("nan"), unit, large, meaning) for name, (unit, meaning) in WIRE_SCALARS.items()),
        *(_per_joint(f"wire.{name}", unit, large, meaning) for name, (unit, meaning) in WIRE_ARRAYS.items()),
        *(Declaration(f"servo.{name}", value, unit, large, meaning) for name, (value, unit, meaning) in SERVO.items()),
        Declaration("model.duration", 0.0, "s", large, "length of the recording that effects of time were fitted on"),
    ]


def arm_from(flat: Mapping[str, Any]) -> Arm:
    """The arm of flat parameters. Raises ModelError for missing or misfitting values."""
    joints = tuple(str(joint) for joint in flat.get("arm.joints", [ANY_JOINTS]))
    if len(set(joints)) != len(joints) or not joints:
        raise ModelError(f"arm.joints must be different names, one or more: got {list(joints)}")
    wire = _wire(flat, len(joints))
    here = len(joints)
    ratio = _array(flat, "wire.ratio", here, wire.ratio if wire else 1.0)
    if np.any(ratio == 0.0):
        raise ModelError("wire.ratio is 0: a joint that the gearbox does not move")
    return Arm(
        joints=joints,
        ratio=ratio,
        dead_band=_array(flat, "wire.dead_band", here, wire.dead_band if wire else 0.0),
        lower=_array(flat, "arm.lower", here, -ANY_ANGLE),
        upper=_array(flat, "arm.upper", here, ANY_ANGLE),
        link_length=_optional(flat, "arm.link_length", here),
        link_mass=_optional(flat, "arm.link_mass", here),
        compliance=_optional(flat, "wire.compliance", here) if wire is None or _given(flat, "wire.compliance") else wire.compliance,
        payload=float(flat.get("arm.payload", 0.0)),
        gravity=float(flat.get("arm.gravity", GRAVITY)),
        wire=wire,
        **{name: float(flat.get(f"servo.{name}", value)) for name, (value, _, _) in SERVO.items()},
    )


def arm_parameters(arm: Arm) -> dict[str, Any]:
    """Flat parameters that give the arm back."""
    flat: dict[str, Any] = {"arm.joints": list(arm.joints)}
    plain = {"arm.lower": arm.lower, "arm.upper": arm.upper, "arm.link_length": arm.link_length, "arm.link_mass": arm.link_mass}
    if arm.wire is None or not np.allclose(arm.ratio, arm.wire.ratio):
        plain["wire.ratio"] = arm.ratio
    if arm.wire is None or not np.allclose(arm.dead_band, arm.wire.dead_band):
        plain["wire.dead_band"] = arm.dead_band
    if arm.wire is None:
        plain["wire.compliance"] = arm.compliance
    flat |= {name: values.tolist() for name, values in plain.items() if len(values)}
    flat |= {"arm.payload": arm.payload, "arm.gravity": arm.gravity}
    if arm.wire is not None:
        flat |= {f"wire.{name}": float(getattr(arm.wire, name)) for name in WIRE_SCALARS}
        flat |= {f"wire.{name}": getattr(arm.wire, name).tolist() for name in WIRE_ARRAYS}
    return flat | {f"servo.{name}": float(getattr(arm, name)) for name in SERVO}


def check_names(given: Iterable[str], known: set[str]) -> None:
    """Raise ModelError for a parameter that does not exist, naming the nearest one."""
    for name in given:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            raise ModelError(f"unknown parameter {name!r}" + (f": did you mean {near[0]!r}?" if near else ""))


def _wire(flat: Mapping[str, Any], joints: int) -> Wire | None:
    if not _given(flat, "wire.shaft_radius"):
        return None
    missing = [name for name in (*WIRE_SCALARS, *WIRE_ARRAYS) if not _given(flat, f"wire.{name}")]
    if missing:
        raise ModelError(f"the wire's formula wants wire.{', wire.'.join(missing)} as well (or give wire.ratio and wire.dead_band)")
    scalars = {name: float(flat[f"wire.{name}"]) for name in WIRE_SCALARS}
    return Wire(**scalars, **{name: _array(flat, f"wire.{name}", joints, 0.0) for name in WIRE_ARRAYS})


def _given(flat: Mapping[str, Any], name: str) -> bool:
    values = np.atleast_1d(np.asarray(flat.get(name, []), dtype=float))
    return bool(values.size) and not bool(np.all(np.isnan(values)))


def _optional(flat: Mapping[str, Any], name: str, joints: int) -> Array:
    return _array(flat, name, joints, 0.0) if _given(flat, name) else np.empty(0)


def _array(flat: Mapping[str, Any], name: str, joints: int, default: float | Array) -> Array:
    """(joints,) values; one value stands for all joints."""
    values = np.atleast_1d(np.asarray(flat[name] if _given(flat, name) else default, dtype=float))
    if values.size not in (1, joints):
        raise ModelError(f"{name} has {values.size} values for {joints} joints: give one per joint")
    if not np.all(np.isfinite(values)):
        raise ModelError(f"{name} = {values.tolist()}: every value must be a finite number")
    return np.broadcast_to(values, (joints,)).copy()
