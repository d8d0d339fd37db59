"""The demo's picture: measured, nominal and fitted over a run that the fit has not seen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.nominal import COUNT, JOINTS, Array

INK, MUTED, LINE = "#1b2430", "#66707c", "#d9dee4"
NOMINAL, FITTED, SHADE = "#d1722c", "#0a6a8f", "#e3eff4"
SETTLED = 3.0  # s that do not count: the play has not engaged
WINDOW = 1.5  # s of the close-up


@dataclass(frozen=True)
class Comparison:
    """Stamps (n,) s and joint angles (n, 5) rad of the second run; ``noise``: rad rms of the sensors."""

    t: Array
    measured: Array
    nominal: Array
    fitted: Array
    noise: float

    def rms(self, predicted: Array) -> Array:
        """Of measured less predicted, per joint (5,) rad, once the play has engaged."""
        late = self.t - self.t[0] > SETTLED
        out: Array = np.sqrt(((self.measured - predicted)[late] ** 2).mean(axis=0))
        return out


def draw(comparison: Comparison, path: Path) -> None:
    """Write the picture as PNG."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    style: Any = {
        "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": LINE,
        "xtick.color": MUTED, "ytick.color": MUTED, "text.color": INK, "axes.labelcolor": MUTED,
        "axes.titlelocation": "left", "axes.titlesize": 10,
    }  # fmt: skip
    with plt.rc_context(style):
        figure = plt.figure(figsize=(11, 6), layout="constrained")
        parts: Any = figure.subfigures(1, 2, width_ratios=[1, 1.25])
        left, right = parts
        joint, start = _worst(comparison)
        whole, close = left.subplots(2, 1, height_ratios=[1, 1.5])
        _whole(whole, comparison, joint, start)
        _close(close, comparison, joint, start)
        _residuals(right.subplots(COUNT, 1), comparison)
        figure.savefig(path, dpi=130)
        plt.close(figure)


def _worst(c: Comparison) -> tuple[int, float]:
    """The joint with the largest misfit, and the start of a window in which it is large beside the motion."""
    joint = int(np.argmax(c.rms(c.nominal)))
    apart, angle = (c.measured - c.nominal)[:, joint], c.measured[:, joint]
    starts = np.arange(c.t[0] + SETTLED, c.t[-1] - WINDOW, 0.1)
    best = (-1.0, float(c.t[0]))
    for start in starts:
        some = (c.t >= start) & (c.t <= start + WINDOW)
        best = max(best, (float((apart[some] ** 2).mean() ** 0.5 / np.ptp(angle[some])), float(start)))
    return joint, best[1]


def _lines(axis: Any, c: Comparison, joint: int, some: Any, **how: Any) -> None:
    t = c.t[some]
    axis.plot(t, 1e3 * c.nominal[some, joint], color=NOMINAL, lw=1.6, label="nominal simulation", **how)
    axis.plot(t, 1e3 * c.fitted[some, joint], color=FITTED, lw=1.6, label="fitted model", **how)


def _whole(axis: Any, c: Comparison, joint: int, start: float) -> None:
    axis.axvspan(start, start + WINDOW, color=SHADE, lw=0)
    axis.plot(c.t, 1e3 * c.measured[:, joint], color=INK, lw=1.0)
    axis.set(title=f"{JOINTS[joint]} over the second run", ylabel="angle [mrad]", xlim=(c.t[0], c.t[-1]))


def _close(axis: Any, c: Comparison, joint: int, start: float) -> None:
    some = (c.t >= start) & (c.t <= start + WINDOW)
    t = c.t[some]
    axis.plot(t, 1e3 * c.measured[some, joint], ".", color=INK, ms=4, label="measured")
    _lines(axis, c, joint, some)
    axis.set(title="the shaded part, close up", xlabel="time [s]", ylabel="angle [mrad]", xlim=(t[0], t[-1]))
    axis.legend(frameon=False, loc="best")


def _residuals(axes: Any, c: Comparison) -> None:
    before, after = (1e3 * (c.measured - x) for x in (c.nominal, c.fitted))
    rms = [1e3 * c.rms(x) for x in (c.nominal, c.fitted)]
    top = 1.2 * np.abs(before[c.t > c.t[0] + SETTLED]).max()
    for j, axis in enumerate(axes):
        axis.plot(c.t, before[:, j], color=NOMINAL, lw=0.9)
        axis.plot(c.t, after[:, j], color=FITTED, lw=0.7)
        axis.set(ylim=(-top, top), ylabel=JOINTS[j], xlim=(c.t[0], c.t[-1]))
        words = f"rms {rms[0][j]:.2f} → {rms[1][j]:.2f} mrad"
        axis.text(1.0, 1.0, words, transform=axis.transAxes, ha="right", va="bottom", fontsize=8, color=MUTED)
        axis.tick_params(labelbottom=j == COUNT - 1)
    axes[0].set_title("measured less simulated [mrad]")
    axes[-1].set_xlabel(f"time [s]     (noise of the sensors: {1e3 * c.noise:.2f} mrad rms)")
