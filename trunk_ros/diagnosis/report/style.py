"""How figures look, and how they get into the page."""

from __future__ import annotations

import base64
import io
import re
import warnings
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from trunk_ros.compiled import Array

INK, MUTED, LINE, GREY, ACCENT = "#1b2430", "#66707c", "#d9dee4", "#98a1ab", "#0a6a8f"
SHADE = "#e3eff4"
RC: Any = {  # newer matplotlib types the keys, older does not know the type
    "font.family": "sans-serif", "font.size": 8.5, "axes.titlesize": 9.0, "axes.labelsize": 8.5,
    "axes.titlelocation": "left", "axes.titlecolor": INK, "axes.labelcolor": MUTED, "text.color": INK,
    "axes.edgecolor": LINE, "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.8,
    "axes.formatter.useoffset": False, "axes.unicode_minus": True,
    "xtick.color": LINE, "ytick.color": LINE, "xtick.labelcolor": MUTED, "ytick.labelcolor": MUTED,
    "xtick.labelsize": 8.0, "ytick.labelsize": 8.0, "xtick.major.size": 2.5, "ytick.major.size": 2.5,
    "xtick.minor.size": 0.0, "ytick.minor.size": 0.0, "legend.frameon": False, "legend.fontsize": 8.5,
    "text.parse_math": False,  # names from a recording are data, a $ among them is a $
    "text.usetex": False, "savefig.transparent": True, "svg.fonttype": "none", "svg.hashsalt": "trunk_ros",
}  # fmt: skip
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', 'DejaVu Sans', sans-serif"
SHARP = 190  # dots per inch of what is drawn as pixels
LONGEST = 28
CELLS = 400  # of an envelope
PLAIN = FuncFormatter(lambda x, _: f"{x:g}")

P = ParamSpec("P")
R = TypeVar("R")


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Run a function with the house's settings of matplotlib, and leave no trace of them."""

    @wraps(draw)
    def inside(*args: P.args, **kwargs: P.kwargs) -> R:
        with mpl.rc_context(RC), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph .* missing")  # the browser has the glyphs
            return draw(*args, **kwargs)

    return inside


@styled
def image(figure: Figure) -> str:
    """A figure as the address of an image that needs no other file; an image cannot act on the page."""
    held = io.StringIO()
    figure.savefig(held, format="svg", dpi=SHARP, metadata={"Date": None})
    text = held.getvalue()
    for family in set(_families(text)):
        text = text.replace(family, FONT)
    text = re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]), text)  # 0.01 pt do
    return "data:image/svg+xml;base64," + base64.b64encode(text.encode("utf-8", "replace")).decode("ascii")


def _families(text: str) -> list[str]:
    """What matplotlib wrote as lists of fonts."""
    return [part.split(";")[0].split('"')[0] for part in text.split("font-family: ")[1:]] + [
        part.split("px ", 1)[1].split(";")[0].split('"')[0]
        for part in text.split("font: ")[1:]
        if "px " in part[:24]
    ]


def label(name: str) -> str:
    """A name for a figure: what cannot be drawn replaced, not too long."""
    drawn = "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in name)
    return drawn if len(drawn) <= LONGEST else drawn[: LONGEST - 1] + "…"


def envelope(stamp: Array, values: Array) -> tuple[Array, Array, Array]:
    """Times and the least and greatest value (CELLS,) around each; NaN where a cell has none."""
    edges = np.linspace(stamp[0], stamp[-1], CELLS + 1)
    known = np.isfinite(values)
    cell = np.clip(np.searchsorted(edges, stamp[known], side="right") - 1, 0, CELLS - 1)
    low, high = np.full(CELLS, np.inf), np.full(CELLS, -np.inf)
    np.minimum.at(low, cell, values[known])
    np.maximum.at(high, cell, values[known])
    empty = ~np.isfinite(low)
    low[empty] = high[empty] = np.nan
    return (edges[:-1] + edges[1:]) / 2, low, high


def limits(axis: Axes, values: Array, whole: Array, share: float = 0.002) -> None:
    """Let the y axis hold nearly all values, and the ``whole`` of others, with some room."""
    known = values[np.isfinite(values)]
    held = np.concatenate([np.quantile(known, [share, 1 - share]) if len(known) else known, whole])
    if len(held):
        low, high = float(held.min()), float(held.max())
        room = 0.08 * (high - low) or 1.0
        axis.set_ylim(low - room, high + room)
