"""A life in a line of a table: what was measured and the shape that was found, as a small SVG."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from trunk_ros.compiled import Array
from trunk_ros.fleet.together.judged import Judged

ACCENT, GREY, INK = "var(--accent)", "var(--grey)", "var(--ink)"  # of the page: it may be dark
WIDTH, HEIGHT, EDGE = 150.0, 34.0, 3.0
MOST = 120  # points that are drawn


def spark(one: Judged) -> Markup:
    """Dots: value of each recording with its deviation; line: the shape."""
    series = one.series
    keep = np.unique(np.linspace(0, len(series.value) - 1, MOST).astype(int))
    low, high = series.value - series.std, series.value + series.std
    y0, y1 = float(np.min(low)), float(np.max(high))
    x = _scaled(series.time, float(series.time[0]), float(series.time[-1]), WIDTH)

    def y(values: Array) -> Array:
        return HEIGHT - _scaled(values, y0, y1, HEIGHT)

    bars = zip(x[keep], y(low)[keep], y(high)[keep], y(series.value)[keep], strict=True)
    dots = "".join(
        f'<path d="M{a:.1f} {b:.1f}V{c:.1f}" stroke="{GREY}" stroke-width=".7"/>'
        f'<circle cx="{a:.1f}" cy="{d:.1f}" r="1.8" fill="{INK}" fill-opacity=".55"/>'
        for a, b, c, d in bars
    )
    line = "".join(f"L{a:.1f} {b:.1f}" for a, b in _course(one, x, y(one.shape.fitted)))
    path = f'<path d="M{line[1:]}" fill="none" stroke="{ACCENT}" stroke-width="1.6"/>'
    label = f"{series.key.effect} on {series.key.joint} over time"
    return Markup(
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="{WIDTH:g}" height="{HEIGHT:g}" role="img" '
        f'aria-label="{Markup.escape(label)}">{path}{dots}</svg>'
    )


def _course(one: Judged, x: Array, y: Array) -> list[tuple[float, float]]:
    """The shape's corners; a jump goes straight up between two recordings."""
    out: list[tuple[float, float]] = []
    for k in range(len(x)):
        if k and one.shape.kind == "jumps" and k in one.shape.places:
            middle = (x[k - 1] + x[k]) / 2
            out += [(middle, y[k - 1]), (middle, y[k])]
        out.append((x[k], y[k]))
    return out


def _scaled(values: Array, low: float, high: float, size: float) -> Array:
    share = (values - low) / (high - low) if high > low else np.full(len(values), 0.5)
    return np.asarray(EDGE + (size - 2 * EDGE) * share)
