"""The proof's figures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.demo_picture import FITTED, INK, LINE, MUTED, NOMINAL, SHADE
from test.concealed.intervals import Estimate

STYLE: dict[str, Any] = {
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": LINE,
    "xtick.color": MUTED, "ytick.color": MUTED, "text.color": INK, "axes.labelcolor": MUTED,
    "axes.titlelocation": "left", "axes.titlesize": 10,
}  # fmt: skip

WAY_COLORS = (FITTED, NOMINAL, "#7f8a96", "#9b6fae", "#6d9a4f")
LOWEST = -1.0


def _errors(axis: Any, x: list[float], some: list[Estimate], **how: Any) -> None:
    y = np.array([e.value for e in some])
    bars = np.abs([y - [e.low for e in some], [e.high for e in some] - y])
    axis.errorbar(x, y, yerr=bars, fmt="o", ms=4, capsize=2, lw=1.2, **how)
    for at, e in zip(x, some, strict=True):
        axis.annotate(f"{e.n}", (at, e.value), (5, 4), textcoords="offset points", fontsize=7, color=MUTED)


def _strength(axis: Any, found: dict[str, Any]) -> None:
    some = [(low, high, e) for low, high, e in found["strength"] if e.n]
    places = [float(np.sqrt(max(low, 0.25) * min(high, 32.0))) for low, high, _ in some]
    _errors(axis, places, [e for _, _, e in some], color=FITTED)
    axis.set(xscale="log", ylim=(-0.03, 1.05), xlabel="strength [noise of the sensor]", ylabel="recall")
    axis.set_xticks([0.5, 1, 2, 4, 8, 16], ["0.5", "1", "2", "4", "8", "16"])
    axis.set_title("Recall over strength, all effects of the table")


def _calibration(axis: Any, found: dict[str, Any]) -> None:
    axis.plot([0, 1], [0, 1], color=LINE, lw=1)
    some = [(said, e) for said, e in found["calibration"] if e.n]
    _errors(axis, [said for said, _ in some], [e for _, e in some], color=FITTED)
    axis.set(xlim=(0, 1.03), ylim=(-0.03, 1.05), xlabel="stated confidence", ylabel="share that was right")
    axis.set_title("Calibration: on the line is as often right as said")


def _effects(axis: Any, found: dict[str, Any]) -> None:
    names = list(found["effects"])[::-1]
    for key, color, off in (("recall", FITTED, 0.15), ("precision", NOMINAL, -0.15)):
        for row, name in enumerate(names):
            e = found["effects"][name][key]
            axis.plot([e.low, e.high], [row + off] * 2, color=color, lw=1.2)
            axis.plot(e.value, row + off, "o", ms=4, color=color, label=key if row == 0 else None)
    axis.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    axis.set(xlim=(0, 1.02), title="Recall and precision per effect, 95 % intervals")
    axis.legend(frameon=False, loc="lower left")


def _confusion(axis: Any, found: dict[str, Any]) -> None:
    count = found["confusion"]
    rows, columns = (sorted({pair[k] for pair in count}) for k in (0, 1))
    for (hidden, said), n in count.items():
        at, color = (columns.index(said), rows.index(hidden)), SHADE if hidden == said else "#f6dcc9"
        axis.add_patch(_square(at, color))
        axis.text(*at, str(n), ha="center", va="center", fontsize=7)
    axis.set(xlim=(-0.6, len(columns) - 0.4), ylim=(len(rows) - 0.4, -0.6))
    plain = [[name.replace("-", "nothing").replace("_", " ") for name in side] for side in (columns, rows)]
    axis.set_xticks(range(len(columns)), plain[0], rotation=90)
    axis.set_yticks(range(len(rows)), plain[1])
    axis.set(title="Hidden (rows) and said (columns)")


def _square(at: tuple[int, int], color: str) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((at[0] - 0.5, at[1] - 0.5), 1, 1, color=color, lw=0)


def _removed(axis: Any, shares: dict[str, list[float]]) -> None:
    """How many cases have at most so much removed; the lower a curve, the better."""
    for (name, some), color in zip(shares.items(), WAY_COLORS, strict=True):
        shown = np.sort(np.clip(some, LOWEST, 1.0))
        at = np.concatenate([[LOWEST], shown, [1.0]])
        height = np.concatenate([[0.0], np.arange(1, len(shown) + 1), [len(shown)]]) / max(len(shown), 1)
        first = color == FITTED
        axis.step(
            at, height, where="post", color=color, lw=2.2 if first else 1.2, label=name, zorder=2 + first
        )
    axis.axvline(0.0, color=LINE, lw=0.8, zorder=0)
    axis.set(xlim=(LOWEST - 0.02, 1.02), ylim=(0, 1.02), ylabel="share of cases with at most so much")
    axis.set(xlabel=f"share of the error removed on another motion (below {LOWEST:g} drawn there)")
    axis.set_title("Error removed on the same cases: low curves are good")
    axis.legend(frameon=False, fontsize=8)


def save(path: Path, size: tuple[float, float], draw: Callable[[Any], None]) -> None:
    """Draws on one axis and writes the PNG."""
    from matplotlib import pyplot as plt

    figure, axis = plt.subplots(figsize=size, layout="constrained")
    draw(axis)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_figures(found: dict[str, Any], shares: dict[str, list[float]], folder: Path) -> None:
    """Writes proof-*.png into the folder. found: what `evidence` gives; shares: by way, `shares_by_way`."""
    import matplotlib

    matplotlib.use("Agg")
    style: Any = STYLE  # its keys are a closed set to mypy
    with matplotlib.rc_context(style):
        save(folder / "proof-strength.png", (6, 3.6), lambda axis: _strength(axis, found))
        save(folder / "proof-calibration.png", (5, 4), lambda axis: _calibration(axis, found))
        save(folder / "proof-effects.png", (7, 7.5), lambda axis: _effects(axis, found))
        save(folder / "proof-confusion.png", (8, 8), lambda axis: _confusion(axis, found))
        save(folder / "proof-removed.png", (6, 3.6), lambda axis: _removed(axis, shares))
