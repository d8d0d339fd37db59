"""An arm as flat parameters: how it is declared, and what a value must be."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from trunk_ros.arm.arm import GRAVITY, LOADS, SERVO_OF_EACH, STEP
from trunk_ros.compiled import Array
from trunk_ros.errors import ModelError
from trunk_ros.parameter import Declaration

ANY_JOINTS = "*"
ANY_ANGLE = 1e3  # rad: no limit


RENAMED = {"model.duration": "recording.duration"}
"""Names in files of earlier versions. A node cannot have a parameter ``model`` beside a ``model.duration``:
``ros2 param dump`` makes a tree of them."""


def _per_joint(name: str, unit: str, bounds: tuple[float, float], meaning: str) -> Declaration:
    return Declaration(name, [float("nan")], unit, bounds, meaning + ", per joint (nan: not given)")


def _of_servo(name: str, value: float, unit: str, meaning: str, bounds: tuple[float, float]) -> Declaration:
    each = name in SERVO_OF_EACH
    meaning += ", or one per joint" if each else ""
    return Declaration(f"servo.{name}", value, unit, bounds, meaning, free=each)


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
    "delay": (0.0, "s", "age of a setpoint when it acts"),
    "feedforward": (0.0, "1", "share of the setpoint's speed that the velocity loop gets beside the error"),
    "counts_per_rev": (131072.0, "1", "encoder counts per turn of the gearbox shaft"),
}


def declared_arm() -> list[Declaration]:
    """The parameters of an arm, effects aside."""
    large, positive = (0.0, 1e15), (1e-15, 1e15)
    everywhere = (-1e15, 1e15)
    return [
        Declaration(
            "arm.joints", [ANY_JOINTS], "", None, "joint names; '*' for whatever joints a recording has", True
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
            _of_servo(name, value, unit, meaning, large if value == 0.0 else positive)
            for name, (value, unit, meaning) in SERVO.items()
        ),
        Declaration(
            "servo.step",
            STEP,
            "s",
            (0.0, 0.01),
            "time in which the position and velocity loops run; 0: as if without end",
        ),
        Declaration(
            "recording.duration",
            0.0,
            "s",
            large,
            "length of the recording that effects of time were fitted on",
        ),
        Declaration(
            "recording.setpoints",
            "held",
            "",
            None,
            "recorded setpoints: held until the next, or sampled from what moves on between them",
        ),
        Declaration(
            "recording.of",
            [""],
            "",
            None,
            "recordings that curves over time without a name were drawn from: start and length in ns",
        ),
        _per_joint(
            "recording.error", "rad", large, "what the model usually left of what its fit did not see, rms"
        ),
        _per_joint(
            "recording.zero",
            "rad",
            large,
            "what zeros differ by between the recordings it was fitted on, rms",
        ),
        _per_joint(
            "recording.reach", "rad", large, "how far the motors went in the recordings it was fitted on, rms"
        ),
        _per_joint("recording.lowest", "rad", everywhere, "the lowest angle that they led joints to there"),
        _per_joint("recording.highest", "rad", everywhere, "the highest"),
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


def check_names(given: Iterable[str], known: Iterable[str]) -> None:
    """Raise ModelError for a parameter that does not exist, naming the nearest one."""
    for name in given:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            raise ModelError(
                f"unknown parameter {shortened(name)}" + (f": did you mean {near[0]!r}?" if near else "")
            )
