"""Figures of the paper and of what it leaves to further work, as PNG."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trunk_ros.arm import Arm, Wire
from trunk_ros.compiled import Array
from trunk_ros.paper.formulas import LIMIT, PRINTED_FIGURES, deviation, positioning_error, printed_deviation
from trunk_ros.paper.workspace import HYSTERESIS, STRETCH, WORST, Workspace

GREY = "#666666"
SHADES = [colormaps["viridis"](x) for x in np.linspace(0.85, 0.1, 5)]
COLOURS = ("#440154", "#2a9d8f", "#e07b00", "#888888")


def figures_5_and_6(wire: Wire) -> bytes:
    """Error along y and z over the angle of each joint: as the formulas give, and as the print came about."""
    figure = Figure((9, 6.4), layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey="row")
    angle = np.linspace(0, LIMIT, 200)
    ways = {"formulas, Table 1": deviation(wire), "done differently: Δθ of Table 2": printed_deviation()}
    for column, (way, off) in enumerate(ways.items()):
        axes[0, column].set_title(way, loc="left")
        axes[1, column].set_xlabel("joint angle θ / °")
        for row, error in enumerate(positioning_error(angle, off)):
            _joints(axes[row, column], np.degrees(angle), 1e6 * error, PRINTED_FIGURES[row])
    axes[0, 0].set_ylabel("Fig. 5: Δy / µm")
    axes[1, 0].set_ylabel("Fig. 6: Δz / µm")
    return _png(figure)


def _joints(axis: Axes, angle: Array, error: Array, printed: float) -> None:
    beside: dict[str, Any] = {"textcoords": "offset points", "fontsize": 8}
    for joint, shade in enumerate(SHADES):
        axis.plot(angle, error[:, joint], color=shade)
        end = (angle[-1], error[-1, joint])
        axis.annotate(f"joint {joint + 1}", end, (4, 0), va="center", color=shade, **beside)
    axis.plot(angle[[0, -1]], [printed, printed], color=GREY, ls=":", lw=1)
    axis.annotate(f"printed: ~{printed}", (0, printed), (4, 3), color=GREY, **beside)
    below = -0.08 * printed  # room for the lowest label, which the axis would strike through
    axis.set(xlim=(0, angle[-1] * 1.18), ylim=(below, None), xticks=range(0, 25, 5))
    axis.spines[["top", "right"]].set_visible(False)


def tip_over_workspace(arm: Arm, found: Workspace) -> bytes:
    """Maps of the tip's error over where the tip stands, and how often which error is met."""
    figure = Figure((10, 6.4), layout="constrained")
    axes = figure.subplots(2, 2)
    _map(figure, axes[0, 0], arm, found, WORST, np.max)
    _map(figure, axes[0, 1], arm, found, HYSTERESIS, np.median)
    _map(figure, axes[1, 0], arm, found, STRETCH, np.max)
    below = axes[1, 1]
    for (name, error), colour in zip(found.errors.items(), COLOURS, strict=True):
        below.plot(np.sort(1e3 * error), np.linspace(0, 100, len(error)), color=colour, label=name)
    below.set(xlim=(0, None), ylim=(0, 100), xlabel="tip error / mm", ylabel="postures below / %")
    below.set_title("how often", loc="left")
    below.legend(loc="lower right", fontsize=8, frameon=False)
    below.spines[["top", "right"]].set_visible(False)
    return _png(figure)


def _map(figure: Figure, axis: Axes, arm: Arm, found: Workspace, name: str, of: Callable[..., Any]) -> None:
    y, z = 1e3 * found.tip.T
    error = 1e3 * found.errors[name]
    cells = axis.hexbin(y, z, error, gridsize=(40, 16), reduce_C_function=of, mincnt=1, lw=0.2)
    figure.colorbar(cells, ax=axis, label=f"tip error / mm, {of.__name__} of a cell", shrink=0.75)
    for posture in (arm.lower, 0 * arm.lower, arm.upper):
        heading = np.cumsum(posture)
        across = np.cumsum([0.0, *(-np.sin(heading) * arm.link_length)])
        up = np.cumsum([0.0, *(np.cos(heading) * arm.link_length)])
        axis.plot(1e3 * across, 1e3 * up, ".-", color=GREY, lw=1, ms=4)
    axis.set(aspect="equal", xlabel="y / mm", ylabel="z / mm")
    axis.set_title(name, loc="left")


def _png(figure: Figure) -> bytes:
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=120)
    return out.getvalue()
