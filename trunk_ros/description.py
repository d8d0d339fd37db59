"""An arm as flat parameters: how it is declared, read and written."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.arm import GRAVITY, LOADS, Arm, Wire
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError, printable
from trunk_ros.recording.messages.layout import MOST_JOINTS

ANY_JOINTS = "*"
ANY_ANGLE = 1e3  # rad: no limit


@dataclass(frozen=True)
class Declaration:
    """One ROS parameter: the type is that of ``default``; a one-element list stands for one value per
    joint.
    """

    name: str
    default: Any
    unit: str
    bounds: tuple[float, float] | None
    meaning: str
    fixed: bool = False
    """A node takes it at its start only."""


RENAMED = {"model.duration": "recording.duration"}
"""Names in files of earlier versions. A node cannot have a parameter ``model`` beside a ``model.duration``:
``ros2 param dump`` makes a tree of them."""


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
    large, positive = (0.0, 1e15), (1e-15, 1e15)
    return [
        Declaration(
            "arm.joints", [ANY_JOINTS], "", None, "joint names; '*' for whatever joints a recording has", True
        ),
        _per_joint("arm.lower", "rad", (-ANY_ANGLE, ANY_ANGLE), "lower joint limit"),
        _per_joint("arm.upper", "rad", (-ANY_ANGLE, ANY_ANGLE), "upper joint limit"),
        _per_joint("arm.link_length", "m", large, "length of the link that the joint turns"),
        _per_joint("arm.link_mass", "kg", large, "mass of the link, at its middle"),
        Declaration("arm.payload", 0.0, "kg", large, "mass at the tip"),
        Declaration("arm.gravity", GRAVITY, "m/s^2", large, "gravity, along -z"),
        Declaration("arm.load", LOADS[0], "", None, f"the moment on the joints: {', '.join(LOADS)}"),
        _per_joint("wire.ratio", "1", (-1e6, 1e6), "joint angle per gearbox angle, in place of the radii"),
        _per_joint(
            "wire.dead_band", "rad", large, "half-width of the nominal play, in place of the wire's formula"
        ),
        _per_joint(
            "wire.compliance",
            "rad/(N*m)",
            large,
            "nominal deflection per moment, in place of the wire's formula",
        ),
        *(
            Declaration(f"wire.{name}", float("nan"), unit, positive, meaning)
            for name, (unit, meaning) in WIRE_SCALARS.items()
        ),
        *(_per_joint(f"wire.{name}", unit, large, meaning) for name, (unit, meaning) in WIRE_ARRAYS.items()),
        *(
            Declaration(f"servo.{name}", value, unit, positive, meaning)
            for name, (value, unit, meaning) in SERVO.items()
        ),
        Declaration(
            "recording.duration",
            0.0,
            "s",
            large,
            "length of the recording that effects of time were fitted on",
        ),
        _per_joint(
            "recording.error", "rad", large, "what the model left of samples that its fit did not see, rms"
        ),
        _per_joint(
            "recording.reach", "rad", large, "how far the motors went in the recordings it was fitted on, rms"
        ),
    ]


def checked(declaration: Declaration, value: Any) -> Any:
    """A value as its declaration wants it: float, (k,) array, word or list of words. Raises ModelError."""
    name, default = declaration.name, declaration.default
    if isinstance(default, str):
        return _words(name, [value])[0]
    if isinstance(default, list) and isinstance(default[0], str):
        return _words(name, value)
    numbers = _numbers(name, value)
    _check_bounds(declaration, numbers)
    if isinstance(default, list):
        return numbers
    if numbers.size != 1:
        raise ModelError(f"{name} has {numbers.size} values: give 1")
    return float(numbers[0])


def _words(name: str, value: Any) -> list[str]:
    if (
        isinstance(value, str)
        or not isinstance(value, Iterable)
        or not all(isinstance(word, str) for word in value)
    ):
        raise ModelError(f"{name} = {shortened(value)}: must be words")
    return list(value)


def _numbers(name: str, value: Any) -> Array:
    items = value if isinstance(value, Iterable) and not isinstance(value, (str, Mapping)) else [value]
    try:
        numbers = np.array([float(item) for item in items if not isinstance(item, bool)])
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if len(numbers) != len(list(items)) or not len(numbers):
        raise ModelError(f"{name} = {shortened(value)}: must be a number, or one per joint")
    return numbers


def _check_bounds(declaration: Declaration, numbers: Array) -> None:
    low, high = declaration.bounds or (-np.inf, np.inf)
    missing = np.isnan(numbers) & np.isnan(np.ravel(declaration.default)[0])
    if not np.all(missing | ((numbers >= low) & (numbers <= high))):
        wanted = f"{low:g} ... {high:g} {declaration.unit}".rstrip()
        raise ModelError(f"{declaration.name} = {shortened(numbers.tolist())}: must be {wanted}")


def shortened(value: Any) -> str:
    """A value in at most 60 characters of one line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def arm_from(flat: Mapping[str, Any]) -> Arm:
    """The arm of checked flat parameters. Raises ModelError for missing or misfitting values."""
    joints = tuple(printable(joint) for joint in flat.get("arm.joints", [ANY_JOINTS]))
    if len(set(joints)) != len(joints) or not all(joints) or not joints:
        raise ModelError(f"arm.joints must be different names, one or more: got {shortened(list(joints))}")
    if len(joints) > MOST_JOINTS:
        raise ModelError(f"arm.joints names {len(joints)} joints: {MOST_JOINTS} at most")
    here = len(joints)
    wire = _wire(flat, here)
    arm = Arm(
        joints=joints,
        ratio=_array(flat, "wire.ratio", here, wire.ratio if wire else 1.0),
        dead_band=_array(flat, "wire.dead_band", here, wire.dead_band if wire else 0.0),
        lower=_array(flat, "arm.lower", here, -ANY_ANGLE),
        upper=_array(flat, "arm.upper", here, ANY_ANGLE),
        link_length=per_joint(flat, "arm.link_length", here),
        link_mass=per_joint(flat, "arm.link_mass", here),
        compliance=wire.compliance
        if wire and not _given(flat, "wire.compliance")
        else per_joint(flat, "wire.compliance", here),
        payload=flat.get("arm.payload", 0.0),
        gravity=flat.get("arm.gravity", GRAVITY),
        wire=wire,
        load_from=flat.get("arm.load", LOADS[0]),
        **{name: flat.get(f"servo.{name}", value) for name, (value, *_) in SERVO.items()},
    )
    _check_arm(arm)
    return arm


def _check_arm(arm: Arm) -> None:
    if arm.load_from not in LOADS:
        raise ModelError(f"arm.load = {shortened(arm.load_from)}: choose from {', '.join(LOADS)}")
    for joint, ratio, lower, upper in zip(arm.joints, arm.ratio, arm.lower, arm.upper, strict=True):
        if ratio == 0.0:
            raise ModelError(f"wire.ratio of {joint} is 0: the gearbox would not move the joint")
        if lower > upper:
            raise ModelError(f"arm.lower of {joint} is above its arm.upper: {lower:g} > {upper:g} rad")


def arm_parameters(arm: Arm) -> dict[str, Any]:
    """Flat parameters that give the arm back."""
    flat: dict[str, Any] = {"arm.joints": list(arm.joints)}
    arrays = {
        "arm.lower": arm.lower,
        "arm.upper": arm.upper,
        "arm.link_length": arm.link_length,
        "arm.link_mass": arm.link_mass,
    }
    for name in ("ratio", "dead_band", "compliance"):
        own = getattr(arm, name)
        if arm.wire is None or not np.array_equal(own, np.broadcast_to(getattr(arm.wire, name), own.shape)):
            arrays[f"wire.{name}"] = own
    flat |= {name: values.tolist() for name, values in arrays.items() if len(values)}
    flat |= {"arm.payload": float(arm.payload), "arm.gravity": float(arm.gravity), "arm.load": arm.load_from}
    if arm.wire is not None:
        flat |= {f"wire.{name}": float(getattr(arm.wire, name)) for name in WIRE_SCALARS}
        flat |= {f"wire.{name}": getattr(arm.wire, name).tolist() for name in WIRE_ARRAYS}
    return flat | {f"servo.{name}": float(getattr(arm, name)) for name in SERVO}


def check_names(given: Iterable[str], known: Iterable[str]) -> None:
    """Raise ModelError for a parameter that does not exist, naming the nearest one."""
    for name in given:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            raise ModelError(
                f"unknown parameter {shortened(name)}" + (f": did you mean {near[0]!r}?" if near else "")
            )


def _wire(flat: Mapping[str, Any], joints: int) -> Wire | None:
    given = [name for name in (*WIRE_SCALARS, *WIRE_ARRAYS) if _given(flat, f"wire.{name}")]
    missing = [name for name in (*WIRE_SCALARS, *WIRE_ARRAYS) if name not in given]
    if not given:
        return None
    if missing:
        more = ", wire.".join(missing)
        raise ModelError(
            f"the wire's formula wants wire.{more} as well (or give wire.ratio and wire.dead_band)"
        )
    scalars: dict[str, Any] = {name: flat[f"wire.{name}"] for name in WIRE_SCALARS}
    arrays: dict[str, Any] = {name: _array(flat, f"wire.{name}", joints, 0.0) for name in WIRE_ARRAYS}
    return Wire(**scalars, **arrays)


def _given(flat: Mapping[str, Any], name: str) -> bool:
    return not bool(np.all(np.isnan(flat.get(name, np.nan))))


def per_joint(flat: Mapping[str, Any], name: str, joints: int) -> Array:
    """(joints,) values, empty where they are not given. Raises ModelError for a wrong number."""
    return _array(flat, name, joints, 0.0) if _given(flat, name) else np.empty(0)


def _array(flat: Mapping[str, Any], name: str, joints: int, default: float | Array) -> Array:
    """(joints,) values; one value stands for all joints."""
    values = np.atleast_1d(flat[name] if _given(flat, name) else default)
    if values.size not in (1, joints):
        raise ModelError(f"{name} has {values.size} values for {joints} joints: give one per joint")
    if not np.all(np.isfinite(values)):
        raise ModelError(f"{name} = {shortened(values.tolist())}: every value must be a finite number")
    return np.broadcast_to(values, (joints,)).copy()
