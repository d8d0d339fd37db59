"""An arm from flat parameters and back."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.arm.arm import GRAVITY, LOADS, SERVO_OF_EACH, STEP, Arm
from trunk_ros.arm.description import Description
from trunk_ros.arm.files import urdf_text
from trunk_ros.arm.parameters import ANY_ANGLE, ANY_JOINTS, SERVO, WIRE_ARRAYS, WIRE_SCALARS, shortened
from trunk_ros.arm.wire import Wire
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError, printable
from trunk_ros.recording.messages.layout import MOST_JOINTS

WORST = 1e6  # condition of a coupling that can be inverted


def arm_from(flat: Mapping[str, Any], folder: Path | None = None) -> Arm:
    """The arm of checked flat parameters, files being named from ``folder`` on. Raises ModelError for missing
    or misfitting values.
    """
    description = _description(flat, folder)
    joints = _joint_names(flat, description)
    if len(set(joints)) != len(joints) or not all(joints) or not joints:
        raise ModelError(f"arm.joints must be different names, one or more: got {shortened(list(joints))}")
    if len(joints) > MOST_JOINTS:
        raise ModelError(f"arm.joints names {len(joints)} joints: {MOST_JOINTS} at most")
    here = len(joints)
    wire, coupling = _wire(flat, here), _coupling(flat, here)
    lower, upper = limits_in(description, joints)
    ratio = _array(flat, "wire.ratio", here, wire.ratio if wire else 1.0)
    servo: dict[str, Any] = {name: _of_servo(flat, name, here) for name in SERVO}
    arm = Arm(
        joints=joints,
        ratio=ratio if coupling is None else np.ones(here),
        dead_band=_array(flat, "wire.dead_band", here, wire.dead_band if wire else 0.0),
        lower=_array(flat, "arm.lower", here, lower),
        upper=_array(flat, "arm.upper", here, upper),
        link_length=per_joint(flat, "arm.link_length", here),
        link_mass=per_joint(flat, "arm.link_mass", here),
        compliance=wire.compliance
        if wire and not _given(flat, "wire.compliance")
        else per_joint(flat, "wire.compliance", here),
        payload=flat.get("arm.payload", 0.0),
        gravity=_gravity(flat),
        mounting=_three(flat, "arm.mounting"),
        wire=wire,
        load_from=flat.get("arm.load", LOADS[0]),
        description=description,
        coupling=coupling,
        motors=_motors(flat, here),
        step=flat.get("servo.step", STEP),
        servo_stated=any(f"servo.{name}" in flat for name in SERVO_OF_EACH),
        **servo,
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
        return tuple(printable(joint) for joint in flat.get("arm.joints", [ANY_JOINTS]))
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
    if arm.step != STEP:
        flat["servo.step"] = float(arm.step)
    encoder = ("counts_per_rev",) if arm.counts_per_rev != SERVO["counts_per_rev"][0] else ()
    said = SERVO if arm.servo_stated else encoder
    servo = {name: np.asarray(getattr(arm, name), dtype=float) for name in said}
    return flat | {f"servo.{name}": value.tolist() for name, value in servo.items() if value.any()}


def _of_servo(flat: Mapping[str, Any], name: str, joints: int) -> float | Array:
    """A number of the servos: one for all, or (joints,)."""
    values = _array(flat, f"servo.{name}", joints, SERVO[name][0])
    return values if np.size(flat.get(f"servo.{name}", 0.0)) > 1 else float(values[0])


def _plain(gravity: float | tuple[float, float, float]) -> float | list[float]:
    return list(gravity) if isinstance(gravity, tuple) else float(gravity)


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
