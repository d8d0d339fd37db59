"""Values of what is said of a joint, and their units."""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, log10
from typing import Any

from trunk_ros.levels import TENFOLD
from trunk_ros.parameter import Parameter

SMALL = {"rad": (1e3, "mrad"), "m": (1e3, "mm"), "s": (1e3, "ms")}


def unit_of(unit: str, joint: str) -> str:
    """A unit on a joint whose position is in the unit ``joint``: on a slide moments are
    forces.
    """
    return unit if joint == "rad" else unit.replace("rad", joint).replace("(N*m)", "N").replace("N*m", "N")


def unit_on(parameter: Parameter, joint: str) -> str:
    """A unit on a joint whose position is in the unit ``joint``."""
    if joint == "rad" or not parameter.slide:
        return unit_of(parameter.unit, joint)
    return parameter.slide if joint == "m" else parameter.slide.replace(" m", "")


def sized(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, in thousandths where it is small; without an exponent where it can be."""
    usual = 1.0, "" if unit == "1" else unit
    factor, name = SMALL.get(unit, usual) if abs(value) < 1.0 else usual
    return f"{float(f'{value * factor:.{digits}g}'):g} {name}".rstrip()


def placed(value: float, unit: str) -> str:
    """A position with its sign and unit; a mere number has none."""
    return f"{value:+.2f} {'' if unit == '1' else unit}".rstrip()


def per_second(unit: str) -> str:
    """The unit of a speed."""
    return "per s" if unit == "1" else f"{unit}/s"


def as_read(value: Mapping[str, Any]) -> str:
    """A parameter of diagnosis.json as one reads it: one that was held has no spread, and one that the data
    do not determine no value.
    """
    if not isinstance(value["value"], float):
        return str(value["value"] or "")
    if is_open(value):
        return UNTOLD
    unit = "" if value["unit"] == "1" else f" {value['unit']}"
    if not value["std"]:
        return f"{value['value']:.3g}{unit}"
    digits = 2 + floor(log10(abs(value["value"]) or value["std"])) - floor(log10(value["std"]))
    return f"{value['value']:.{min(max(digits, 1), 5)}g} ± {value['std']:.2g}{unit}"


UNTOLD = "not determined"
ANYWHERE = 1.0  # rad or m: who knows a joint no better than that knows nothing of it


def is_open(value: Mapping[str, Any]) -> bool:
    """Whether a spread is many times a parameter: these data do not determine it. Of angles and lengths zero
    is a place like any other, unless they may be anywhere.
    """
    size, std = abs(value["value"]) if isinstance(value["value"], float) else 0.0, value["std"] or 0.0
    return 0.0 < TENFOLD * size < std and (value["unit"] not in ("rad", "m") or std > ANYWHERE)
