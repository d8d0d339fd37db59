"""Values of what is said of a joint, and their units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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
    """A parameter of diagnosis.json as one reads it: one that was held has no spread."""
    if not isinstance(value["value"], float):
        return str(value["value"] or "")
    spread = f" ± {value['std']:.2g}" if value["std"] else ""
    return f"{value['value']:.4g}{spread} {'' if value['unit'] == '1' else value['unit']}".strip()
