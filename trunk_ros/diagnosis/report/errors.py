"""Figures of the error: before and after on unseen data, and over time with the culprit spans shaded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from trunk_ros.compiled import Array
from trunk_ros.data.noise import is_none
from trunk_ros.diagnosis.report.signals import Signal, concerns, entries, signals
from trunk_ros.diagnosis.report.style import (
    ACCENT,
    GREY,
    INK,
    LINE,
    MUTED,
    PLAIN,
    SHADE,
    envelope,
    label,
    limits,
    styled,
)
from trunk_ros.diagnosis.report.units import multiple
from trunk_ros.diagnosis.verdict.answer import STAGES, Answer
from trunk_ros.recording.signal.gaps import runs

WIDTH = 9.4  # inches
WELL_ABOVE = 3.0  # times the noise, over a window
WINDOW = 0.5  # s
MOST = 10  # signals in one figure
ABOVE = 1.15  # times the noise: what is more is seen, and said to be left
LEAST = 0.5  # times the noise; a simulated arm without noise has errors of 0, which a log axis cannot show


@dataclass(frozen=True)
class Ratio:
    """Root mean square error of one signal on unseen data over its noise, or over the steps of the encoders
    where those are larger; with standard errors.
    """

    stage: str
    name: str
    of: str
    """What these are multiples of: ``noise`` or, where those are larger, ``encoder steps``."""
    before: float
    before_std: float
    after: float
    after_std: float


def ratios(result: Answer) -> list[Ratio]:
    """All signals that were judged and have noise, or steps, in the order of the signal path."""
    out = []
    for stage in STAGES:
        for name, said in entries(result, stage).items():
            floor, steps = (said.get(key) or 0.0 for key in ("noise_floor", "resolution"))
            noise = math.nan if is_none(max(floor, steps)) else max(floor, steps)
            keys = ("rmse_before", "rmse_before_std", "rmse_after", "rmse_after_std")
            values = [float(said.get(key) or 0.0) / noise for key in keys]
            if all(math.isfinite(value) for value in values):
                out.append(Ratio(stage, name, "encoder steps" if steps > floor else "noise", *values))
    return out


@styled
def figure_before_after(result: Answer) -> Figure:
    """Error of each signal on samples that no fit saw, in units of its noise."""
    rows = ratios(result)
    figure = Figure((5.2, 0.24 * len(rows) + 0.85), layout="constrained")
    axis = figure.subplots()
    fitted = bool(result.findings) and bool(rows)
    for y, row in enumerate(rows):
        before, after = max(row.before, LEAST), max(row.after, LEAST)
        axis.plot([before, after], [y, y], color=LINE, lw=2.2, zorder=1, solid_capstyle="round")
        _dot(axis, before, row.before_std, y, GREY, "before" if y == 0 and fitted else "")
        _dot(axis, after, row.after_std, y, ACCENT, "after" if y == 0 and fitted else "")
    axis.axvline(1.0, color=INK, lw=0.8, ls=(0, (3, 3)), zorder=0)
    grain = "sensor noise" if all(r.of == "noise" for r in rows) else "noise or encoder steps"
    axis.set_yticks(range(len(rows)), [f"{row.stage} · {label(row.name)}" for row in rows])
    axis.set(xscale="log", ylim=(len(rows) - 0.4, -0.6), xlabel=f"rms error on unseen data / {grain}")
    _plain(axis, rows)
    axis.tick_params(axis="y", length=0, labelcolor=INK)
    axis.spines["left"].set_visible(False)
    if fitted:
        figure.legend(loc="outside upper right", ncols=2, handletextpad=0.2, columnspacing=1.2)
    return figure


def _dot(axis: Axes, value: float, std: float, y: float, colour: str, name: str) -> None:
    """A value with its interval of two standard errors."""
    spread = [[min(2 * std, 0.9 * value)], [2 * std]]
    axis.errorbar(value, y, xerr=spread, fmt="o", ms=5, color=colour, lw=1.3, zorder=3, label=name or None)


def _plain(axis: Axes, rows: list[Ratio]) -> None:
    """Ticks 1, 2, 5, 10 … as numbers."""
    sizes = [1.0, *(max(r.before + 2 * r.before_std, r.after) for r in rows)]
    least = max(min([1.0, *(min(r.before, r.after) for r in rows)]), LEAST)
    top = max(1.6, 1.25 * max(sizes))
    steps = (1, 1.2, 1.5, 2, 3, 5, 7, 8, 9) if top < 3 else (1, 2, 5) if top < 300 else (1,)
    ticks = [s * 10**k for k in range(-2, math.ceil(math.log10(top)) + 1) for s in steps]
    axis.set_xlim(min(0.8, 0.8 * least), top)
    axis.set_xticks([t for t in ticks if axis.get_xlim()[0] <= t <= top])
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(PLAIN)


def culprit_spans(signal: Signal) -> list[tuple[float, float]]:
    """Times [s] between which the nominal error is well above the noise, neighbours joined."""
    start, end = float(signal.stamp[0]), float(signal.stamp[-1])
    cells = max(int(min((end - start) / WINDOW, 400)), 1)
    edges = np.linspace(start, end, cells + 1)
    cell = np.clip(np.searchsorted(edges, signal.stamp, side="right") - 1, 0, cells - 1)
    known = np.isfinite(signal.error_before)
    count = np.bincount(cell[known], minlength=cells)
    power = np.bincount(cell[known], weights=signal.error_before[known] ** 2, minlength=cells)
    loud = power > count * (WELL_ABOVE * signal.noise) ** 2
    return [(float(edges[a]), float(edges[b])) for a, b in runs(loud)]


def loud(signal: Signal) -> float:
    """Share of the time in culprit spans."""
    length = float(signal.stamp[-1] - signal.stamp[0])
    return sum(end - start for start, end in culprit_spans(signal)) / length if length > 0.0 else 1.0


def loudest(result: Answer, few: list[Signal]) -> list[Signal]:
    """The same signals, the largest error in times the noise first."""
    size = {(r.stage, r.name): r.before for r in ratios(result)}
    return sorted(few, key=lambda s: -size.get((s.stage, s.name), 0.0))


def shown_over_time(result: Answer) -> list[Signal]:
    """The signals with something to see, the loudest if there are many; the wire's where there is nothing."""
    every = signals(result)
    size = {(r.stage, r.name): r.before for r in ratios(result)}
    loud = [
        s
        for s in every
        if size.get((s.stage, s.name), 0.0) > ABOVE
        or any(concerns(f, s.stage, s.name) for f in result.findings)
        or any(u.stage == s.stage and s.name in u.joints for u in result.unexplained)
    ]
    chosen = loud or [s for s in every if s.stage == "wire"]
    kept = loudest(result, chosen)[:MOST]
    return [s for s in chosen if any(s is k for k in kept)]


@styled
def figure_over_time(shown: list[Signal]) -> Figure:
    """Error of each signal over the first recording, nominal in grey, with all that was found in colour."""
    figure = Figure((WIDTH, (0.92 if len(shown) > 2 else 1.3) * len(shown) + 0.5), layout="constrained")
    axes = np.atleast_1d(np.asarray(figure.subplots(len(shown), 1, sharex=True)))
    for axis, signal in zip(axes, shown, strict=True):
        _over_time(axis, signal)
    axes[-1].set_xlabel("time / s")
    figure.supylabel("residual", size=axes[0].yaxis.label.get_size(), color=MUTED)
    used = [GREY, *([ACCENT] if any(s.changed for s in shown) else []), SHADE]
    handles = [axes[0].fill_between([], [], color=c, label=LEGEND[c]) for c in used]
    figure.legend(handles=handles, loc="outside upper right", ncols=3, columnspacing=1.2)
    return figure


LEGEND = {GREY: "nominal simulation", ACCENT: "with what was found", SHADE: "well above the noise"}


def _over_time(axis: Axes, signal: Signal) -> None:
    before, after = signal.error_before, signal.error_after
    factor, unit = multiple(_size(before), signal.unit)
    for start, end in culprit_spans(signal):
        axis.axvspan(start, end, color=SHADE, lw=0, zorder=0)
    for values, colour in ((before, GREY), (after, ACCENT))[: 1 + signal.changed]:
        t, low, high = envelope(signal.stamp, factor * values)
        hair = 0.004 * 2 * factor * _size(before)  # so that a single value is seen too
        axis.fill_between(t, low - hair, high + hair, color=colour, lw=0.4)
    axis.axhline(0.0, color=INK, lw=0.4)
    limits(axis, factor * np.concatenate([before, after]), np.zeros(1))
    axis.set_xlim(signal.stamp[0], signal.stamp[-1])
    axis.set_ylabel(unit)
    axis.set_title(f"{signal.stage} · {label(signal.name)}", pad=2)
    share = f"{loud(signal):.0%} of the time well above the noise" if culprit_spans(signal) else ""
    axis.set_title(share, pad=2, loc="right", color=MUTED, size=8)


def _size(values: Array) -> float:
    known = np.abs(values[np.isfinite(values)])
    return float(np.quantile(known, 0.99)) if len(known) else 1.0
