"""Values of what is said of a joint, and their units."""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, log10
from typing import Any

from trunk_ros.diagnosis.levels import NOTABLE, TENFOLD

SMALL = {"rad": (1e3, "mrad"), "m": (1e3, "mm"), "s": (1e3, "ms")}


def unit_of(unit: str, joint: str) -> str:
    """A parameter's unit on a joint whose position is in the unit ``joint``: on a slide moments are
    forces.
    """
    return unit if joint == "rad" else unit.replace("rad", joint).replace("(N*m)", "N").replace("N*m", "N")


def sized(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, in thousandths where it is small."""
    usual = 1.0, "" if unit == "1" else unit
    factor, name = SMALL.get(unit, usual) if abs(value) < 1.0 else usual
    return f"{value * factor:.{digits}g} {name}".rstrip()


def as_read(value: Mapping[str, Any]) -> str:
    """A parameter of diagnosis.json as one reads it: one that was held has no spread, and of one that is
    less than its spread only a bound is told, where there is any.
    """
    if not isinstance(value["value"], float):
        return str(value["value"] or "")
    unit = "" if value["unit"] == "1" else f" {value['unit']}"
    if is_open(value):
        most = bound(value)
        return UNTOLD if most is None else f"{UNTOLD} ({AT_MOST} {most:.2g}{unit})"
    if not value["std"]:
        return f"{value['value']:.3g}{unit}"
    digits = 2 + floor(log10(abs(value["value"]))) - floor(log10(value["std"]))
    return f"{value['value']:.{min(digits, 5)}g} ± {value['std']:.2g}{unit}"


UNTOLD, AT_MOST = "not determined", "at most"


def is_open(value: Mapping[str, Any]) -> bool:
    """Whether a parameter is less than its spread: these data do not determine it."""
    return isinstance(value["value"], float) and (value["std"] or 0.0) > abs(value["value"])


def bound(value: Mapping[str, Any]) -> float | None:
    """How large such a parameter may be; None where its spread is that of nothing known."""
    size = abs(value["value"])
    return size + NOTABLE * value["std"] if value["std"] < TENFOLD * size else None
