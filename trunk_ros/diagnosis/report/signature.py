"""The signature plot of a finding: the residual without it, and its contribution as a line."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from trunk_ros.diagnosis.report.errors import MOST, WIDTH
from trunk_ros.diagnosis.report.signals import acts, concerns, contributions, signals
from trunk_ros.diagnosis.report.style import ACCENT, GREY, LINE, MUTED, PLAIN, label, limits, styled
from trunk_ros.diagnosis.report.view import POINTS, Cloud, cloud, view_of
from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.diagnosis.verdict.finding import Finding

WIDE = 5  # panels in a row


@styled
def figure_signature(result: Answer, finding: Finding) -> Figure | None:
    """One panel per signal of a finding; None where no signal was kept."""
    parts = contributions(result, finding)
    mine = [s for s in signals(result) if concerns(finding, s.stage, s.name) and s.valid.any()][:MOST]
    if not mine:
        return None
    clouds = [cloud(result, view_of(finding, s.name), s, parts[s.name]) for s in mine]
    columns = min(WIDE, len(mine))
    rows = math.ceil(len(mine) / columns)
    tall = 2.0 if columns > 2 else 2.3
    figure = Figure((WIDTH if columns > 1 else 0.5 * WIDTH, tall * rows + 0.2), layout="constrained")
    axes = np.atleast_1d(np.asarray(figure.subplots(rows, columns))).ravel()
    for axis, signal, held in zip(axes, mine, clouds, strict=False):
        _panel(axis, held)
        axis.set_title(label(signal.name), pad=3)
    for axis in axes[len(mine) :]:
        axis.set_visible(False)
    _label(figure, list(axes), clouds, columns)
    return figure


def _label(figure: Figure, axes: list[Axes], clouds: list[Cloud], columns: int) -> None:
    """Labels once where they are the same, else on each panel."""
    across, up = {label_of(c) for c in clouds}, {c.y_label for c in clouds}
    for k, (axis, held) in enumerate(zip(axes, clouds, strict=False)):
        if len(up) > 1 or k % columns == 0:
            axis.set_ylabel(held.y_label)
        if len(across) > 1:
            axis.set_xlabel(label_of(held))
    if len(across) == 1:
        figure.supxlabel(across.pop(), fontsize=8.5, color=MUTED)


def label_of(held: Cloud) -> str:
    """Label of the abscissa, safe to draw."""
    name, slash, unit = held.x_label.rpartition(" / ")
    return label(name) + slash + unit if len(name) > 40 else held.x_label


def _panel(axis: Axes, held: Cloud) -> None:
    axis.axhline(0.0, color=LINE, lw=0.8, zorder=0)
    dot, width = (4.5, 1.1) if 2 * len(held.x) < POINTS else (2.6, 1.7)
    axis.plot(held.x, held.y, ".", ms=dot, mew=0, color=GREY, alpha=0.6, rasterized=True)
    if np.any(held.curve_y):
        axis.plot(held.curve_x, held.curve_y, color=ACCENT, lw=width, solid_capstyle="round")
    if held.log:
        axis.set_xscale("log")
        axis.xaxis.set_major_formatter(PLAIN)
    limits(axis, held.y, held.curve_y, 0.01)
    axis.locator_params(axis="y", nbins=5)
    if not held.log:
        axis.locator_params(axis="x", nbins=4)


def reading(result: Answer, finding: Finding) -> str:
    """How to read the plot."""
    over = {view_of(finding, s.name) for s in signals(result) if concerns(finding, s.stage, s.name)}
    text = "Grey dots: residual."
    if acts(finding):
        text = "Grey dots: residual without this effect. Line: this effect's contribution."
    if any(v.along for v in over):
        text += " Residuals are signed along the motion: below zero the joint lags."
    if any(v.window for v in over):
        text += " Shown: the stretch of time in which it does most."
    signature = str(finding.evidence.get("signature", ""))
    return f"{text} What to look for: {signature[0].lower()}{signature[1:]}" if signature else text
