"""Numbers for readers: SI prefixes, three digits, or as many as the spread tells."""

from __future__ import annotations

import math

from trunk_ros.levels import ROUGH
from trunk_ros.words import significant

# Largest size (in the SI unit) up to which a multiple is used; the last one holds for all above.
STEPS: dict[str, tuple[tuple[float, float, str], ...]] = {
    "rad": (
        (1e-7, 1e9, "nrad"),
        (1e-4, 1e6, "µrad"),
        (0.1, 1e3, "mrad"),
        (math.inf, math.degrees(1), "°"),
    ),
    "m": ((1e-4, 1e6, "µm"), (1.0, 1e3, "mm"), (math.inf, 1.0, "m")),
    "s": ((1e-4, 1e6, "µs"), (0.5, 1e3, "ms"), (math.inf, 1.0, "s")),
    "kg": ((1.0, 1e3, "g"), (math.inf, 1.0, "kg")),
    "N*m": ((0.1, 1e3, "mN·m"), (math.inf, 1.0, "N·m")),
}
RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
NBSP = "\N{NO-BREAK SPACE}"


def multiple(size: float, unit: str) -> tuple[float, str]:
    """Factor and label that make numbers of this size (in an SI unit such as ``rad/s``) easy to read."""
    head, slash, tail = unit.partition("/")
    label = tail.replace("*", "·")
    for limit, factor, name in STEPS.get(head, ()):
        if abs(size) < limit and not (slash and name == "°"):
            return factor, name + slash + label
    return 1.0, "" if unit == "1" else head.replace("*", "·") + slash + label


def quantity(
    value: object, std: float | None = None, unit: str = "1", relative: bool = False, size: float = 0.0
) -> str:
    """``1.223 ± 0.012 mrad``; words as they are, a dash where there is no number; ``relative`` in percent.

    The multiple suits the largest of value, spread and ``size``.
    """
    if isinstance(value, str):
        return value
    if not isinstance(value, (int, float)) or not math.isfinite(value):
        return "–"
    factor, label = (100.0, "%") if relative else multiple(_shown(max(abs(value), _spread(std)), size), unit)
    number, spread = float(value) * factor, (std or 0.0) * factor
    if spread > 0.0 and math.isfinite(spread):
        places = min(max(1 - math.floor(math.log10(spread)), 0), 7)
        text = f"{number:.{places}f} ± {spread:.{places}f}"
    else:
        text = significant(number)
    return f"{text}{NBSP}{label}".strip().replace("-", "−")


def _spread(std: float | None) -> float:
    return std if std and math.isfinite(std) else 0.0


def fall(before: float, after: float, unit: str, size: float = 0.0) -> str:
    """``4.65 → 0.095 mrad``: both in the multiple that suits the first, or ``size``, if that suits both."""
    factor, label = multiple(_shown(before, size), unit)
    other, small = multiple(_shown(after, max(before, size)), unit)
    first = significant(factor * before) + (f"{NBSP}{label}" if small != label else "")
    return f"{first} → {significant(other * after, 2)}{NBSP}{small}".strip()


def _shown(value: float, size: float) -> float:
    """The size whose multiple a value is told in: its own where it would be all zeros in that of ``size``."""
    return max(abs(value), size) if abs(value) > ROUGH * size or value == 0.0 else abs(value)


def rounded(value: float, unit: str, size: float = 0.0) -> str:
    """``4.65 mrad``: three digits, for tables at a glance, in the multiple that suits it or ``size``."""
    factor, label = multiple(_shown(value, size), unit)
    return f"{significant(factor * value)}{NBSP}{label}".strip()


def powers(number: float) -> str:
    """Two significant digits, and a power of ten where there are many."""
    if abs(number) < 1e4:
        return significant(number, 2).replace("-", "−")
    head, _, tail = f"{number:.1e}".partition("e")
    return f"{head}{NBSP}×{NBSP}10{str(int(tail)).translate(RAISED)}"


def times(ratio: float | None) -> str:
    """A ratio: ``1.0``, ``15.4``, ``312``, ``1 340``; three digits at most."""
    if ratio is None or not math.isfinite(ratio):
        return "–"
    whole = float(f"{ratio:.2e}")
    return f"{ratio:.1f}" if ratio < 99.95 else f"{whole:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def spoken(effect: str | list[str]) -> str:
    """An effect's ID as words, or those of several that act together."""
    return effect.replace("_", " ") if isinstance(effect, str) else " with ".join(map(spoken, effect))
