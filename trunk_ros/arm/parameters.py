"""An arm as flat parameters: how it is declared, read and written."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.arm.arm import GRAVITY, LOADS, Arm
from trunk_ros.arm.description import Description
from trunk_ros.arm.files import urdf_text
from trunk_ros.arm.wire import Wire
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError

ANY_JOINTS = "*"
ANY_ANGLE = 1e3  # rad: no limit
WORST = 1e6  # condition of a coupling that can be inverted


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
    free: bool = False
    """One number or a list: no ROS type is fixed."""


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
            "arm.joints", [ANY_JOINTS], "", None, "joint names; '*' for whatever joints a recording has"
        ),
        _per_joint("arm.lower", "rad", (-ANY_ANGLE, ANY_ANGLE), "lower joint limit"),
        _per_joint("arm.upper", "rad", (-ANY_ANGLE, ANY_ANGLE), "upper joint limit"),
        _per_joint("arm.link_length", "m", large, "length of the link that the joint turns"),
        _per_joint("arm.link_mass", "kg", large, "mass of the link, at its middle"),
        Declaration(
            "arm.urdf",
            "",
            "",
            None,
            "the arm's URDF in place of lengths, masses, limits: FILE, package://…, text",
        ),
        Declaration("arm.base", "", "", None, "link of the URDF that the arm begins with; '': its first"),
        Declaration("arm.tip", "", "", None, "link of the URDF that the arm ends with; '': its farthest"),
        Declaration("arm.payload", 0.0, "kg", large, "mass at the tip"),
        Declaration(
            "arm.gravity",
            GRAVITY,
            "m/s^2",
            (-1e6, 1e6),
            "gravity along -z, or a vector in the world",
            free=True,
        ),
        Declaration("arm.mounting", [0.0], "rad", (-10.0, 10.0), "roll, pitch, yaw of the base in the world"),
        Declaration("arm.load", LOADS[0], "", None, f"the moment on the joints: {', '.join(LOADS)}"),
        _per_joint("wire.ratio", "1", (-1e6, 1e6), "joint angle per gearbox angle, in place of the radii"),
        Declaration(
            "wire.coupling",
            [float("nan")],
            "1",
            (-1e6, 1e6),
            "joint angle per motor angle, joint by motor, row by row, in place of wire.ratio",
        ),
        Declaration(
            "wire.motors", [""], "", None, "names of the motors, where they are not those of the joints"
        ),
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
            "model.duration", 0.0, "s", large, "length of the recording that effects of time were fitted on"
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
    if isinstance(default, list) or (declaration.free and numbers.size > 1):
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


def arm_from(flat: Mapping[str, Any], folder: Path | None = None) -> Arm:
    """The arm of checked flat parameters, files being named from ``folder`` on. Raises ModelError for missing
    or misfitting values.
    """
    description = _description(flat, folder)
    joints = _joint_names(flat, description)
    if len(set(joints)) != len(joints) or not all(joints) or not joints:
        raise ModelError(f"arm.joints must be different names, one or more: got {shortened(list(joints))}")
    here = len(joints)
    wire, coupling = _wire(flat, here), _coupling(flat, here)
    lower, upper = limits_in(description, joints)
    ratio = _array(flat, "wire.ratio", here, wire.ratio if wire else 1.0)
    arm = Arm(
        joints=joints,
        ratio=ratio if coupling is None else np.ones(here),
        dead_band=_array(flat, "wire.dead_band", here, wire.dead_band if wire else 0.0),
        lower=_array(flat, "arm.lower", here, lower),
        upper=_array(flat, "arm.upper", here, upper),
        link_length=_optional(flat, "arm.link_length", here),
        link_mass=_optional(flat, "arm.link_mass", here),
        compliance=wire.compliance
        if wire and not _given(flat, "wire.compliance")
        else _optional(flat, "wire.compliance", here),
        payload=flat.get("arm.payload", 0.0),
        gravity=_gravity(flat),
        mounting=_three(flat, "arm.mounting"),
        wire=wire,
        load_from=flat.get("arm.load", LOADS[0]),
        description=description,
        coupling=coupling,
        motors=_motors(flat, here),
        **{name: flat.get(f"servo.{name}", value) for name, (value, *_) in SERVO.items()},
    )
    _check_arm(arm)
    return arm


def _description(flat: Mapping[str, Any], folder: Path | None) -> Description | None:
    source = flat.get("arm.urdf", "")
    ends = flat.get("arm.base", ""), flat.get("arm.tip", "")
    if not source:
        if any(ends):
            raise ModelError("arm.base and arm.tip are links of a URDF: give arm.urdf as well")
        return None
    if other := [name for name in ("arm.link_length", "arm.link_mass") if _given(flat, name)]:
        raise ModelError(f"arm.urdf takes the place of {other[0]}: leave one of them out")
    return Description(urdf_text(source, folder), *ends).found(_named(flat))


def _named(flat: Mapping[str, Any]) -> tuple[str, ...]:
    """The joints that a model names; none where it leaves them to others."""
    joints = tuple(flat.get("arm.joints", [ANY_JOINTS]))
    return () if joints == (ANY_JOINTS,) else joints


def _joint_names(flat: Mapping[str, Any], description: Description | None) -> tuple[str, ...]:
    named = _named(flat)
    if description is None:
        return tuple(flat.get("arm.joints", [ANY_JOINTS]))
    own = tuple(joint.name for joint in description.arm_joints)
    if other := [joint for joint in named if joint not in own]:
        raise ModelError(f"arm.joints has {other[0]!r}, the URDF from base to tip {', '.join(own)}")
    return named or own


def limits_in(description: Description | None, joints: tuple[str, ...]) -> tuple[Array, Array]:
    """(joints,) lower and upper limits that a URDF has."""
    known = {} if description is None else {joint.name: joint for joint in description.arm_joints}
    ends = [
        (known[joint].lower, known[joint].upper) if joint in known else (-np.inf, np.inf) for joint in joints
    ]
    lower, upper = np.clip(np.array(ends), -ANY_ANGLE, ANY_ANGLE).T
    return lower, upper


def _gravity(flat: Mapping[str, Any]) -> float | tuple[float, float, float]:
    values = np.ravel(flat.get("arm.gravity", GRAVITY))
    if values.size == 1:
        if values[0] < 0.0:
            raise ModelError(f"arm.gravity = {values[0]:g}: along -z it is 0 or more, or give [x, y, z]")
        return float(values[0])
    return _three(flat, "arm.gravity")


def _three(flat: Mapping[str, Any], name: str) -> tuple[float, float, float]:
    values = np.ravel(flat.get(name, 0.0))
    if values.size == 1 and not values[0]:
        return 0.0, 0.0, 0.0
    if values.size != 3:
        raise ModelError(f"{name} = {shortened(values.tolist())}: give three values")
    return float(values[0]), float(values[1]), float(values[2])


def _coupling(flat: Mapping[str, Any], joints: int) -> Array | None:
    if not _given(flat, "wire.coupling"):
        return None
    values = np.ravel(flat["wire.coupling"])
    if values.size != joints**2:
        raise ModelError(
            f"wire.coupling has {values.size} values for {joints} joints: give a motor per joint, "
            f"{joints} rows of {joints}"
        )
    if _given(flat, "wire.ratio"):
        raise ModelError("wire.coupling takes the place of wire.ratio: leave one of them out")
    matrix = values.reshape(joints, joints)
    if not np.isfinite(matrix).all() or np.linalg.cond(matrix) > WORST:
        raise ModelError(
            "wire.coupling cannot be inverted: no motor angles make the joints go where they should"
        )
    return matrix


def _motors(flat: Mapping[str, Any], joints: int) -> tuple[str, ...]:
    names = tuple(flat.get("wire.motors", [""]))
    if names == ("",):
        return ()
    if len(set(names)) != joints or len(names) != joints or not all(names):
        raise ModelError(f"wire.motors must be {joints} different names: got {shortened(list(names))}")
    return names


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
    if arm.description is not None:
        told = arm.description
        flat |= {"arm.urdf": told.text, "arm.base": told.base, "arm.tip": told.tip}
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
    if arm.coupling is not None:
        del arrays["wire.ratio"]
        arrays["wire.coupling"] = arm.coupling.ravel()
    flat |= {name: values.tolist() for name, values in arrays.items() if len(values)}
    if arm.motors:
        flat["wire.motors"] = list(arm.motors)
    flat |= {"arm.payload": float(arm.payload), "arm.gravity": _plain(arm.gravity), "arm.load": arm.load_from}
    if any(arm.mounting):
        flat["arm.mounting"] = list(arm.mounting)
    if arm.wire is not None:
        flat |= {f"wire.{name}": float(getattr(arm.wire, name)) for name in WIRE_SCALARS}
        flat |= {f"wire.{name}": getattr(arm.wire, name).tolist() for name in WIRE_ARRAYS}
    return flat | {f"servo.{name}": float(getattr(arm, name)) for name in SERVO}


def _plain(gravity: float | tuple[float, float, float]) -> float | list[float]:
    return list(gravity) if isinstance(gravity, tuple) else float(gravity)


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


def _optional(flat: Mapping[str, Any], name: str, joints: int) -> Array:
    return _array(flat, name, joints, 0.0) if _given(flat, name) else np.empty(0)


def _array(flat: Mapping[str, Any], name: str, joints: int, default: float | Array) -> Array:
    """(joints,) values; one value stands for all joints."""
    values = np.atleast_1d(flat[name] if _given(flat, name) else default)
    if values.size not in (1, joints):
        raise ModelError(f"{name} has {values.size} values for {joints} joints: give one per joint")
    if not np.all(np.isfinite(values)):
        raise ModelError(f"{name} = {shortened(values.tolist())}: every value must be a finite number")
    return np.broadcast_to(values, (joints,)).copy()
