"""Lists and numbers as one says them."""

from __future__ import annotations

import math
from collections.abc import Sequence


def listed(words: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}" if words else ""


def many(count: int, noun: str) -> str:
    """``1 row``, ``2 rows``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def significant(number: float, digits: int = 3) -> str:
    """A number with so many significant digits, without an exponent where it can be."""
    if number == 0.0 or not math.isfinite(number):
        return "0" if number == 0.0 else "–"
    kept = float(f"{number:.{digits - 1}e}")
    places = digits - 1 - math.floor(math.log10(abs(kept)))
    return f"{kept:.{max(places, 0)}f}" if places < 9 else f"{kept:.{digits - 1}e}"
