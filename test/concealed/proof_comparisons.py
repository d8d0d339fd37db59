"""The proof's figures of comparisons: the trap of fits that only look good, and the live graph."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from test.concealed.demo_picture import FITTED, INK, LINE, MUTED, NOMINAL
from test.concealed.evidence_others import WAYS
from test.concealed.intervals import Estimate
from test.concealed.proof_figures import LOWEST, STYLE, save


def _point(axis: Any, row: float, e: Estimate, color: str, label: str | None) -> None:
    low, high, value = (max(x, LOWEST) for x in (e.low, e.high, e.value))
    axis.plot([low, high], [row] * 2, color=color, lw=1.4)
    axis.plot(value, row, "o", ms=5, color=color, label=label)


def _trap(axis: Any, others: dict[str, dict[str, Estimate]]) -> None:
    names = list(others)[::-1]
    for row, name in enumerate(names):
        fitted, other = others[name]["fitted"], others[name]["other"]
        if not other.n:
            continue
        ends = [max(x.value, LOWEST) for x in (fitted, other) if x.n]
        axis.plot(ends, [row] * len(ends), color=LINE, lw=5, solid_capstyle="round", zorder=0)
        last = row == len(names) - 1
        if fitted.n:
            _point(axis, row + 0.12, fitted, NOMINAL, "the run that was fitted" if last else None)
        _point(axis, row - 0.12, other, FITTED, "another run of the same arm" if last else None)
        worse = others[name]["worse"]
        axis.text(1.04, row, f"{100 * worse.value:.0f} %", va="center", color=INK, fontsize=9)
    axis.text(1.04, len(names) - 0.45, "made worse", color=MUTED, fontsize=8)
    axis.axvline(0.0, color=MUTED, lw=0.8)
    lows = [e.low for one in others.values() for e in (one["fitted"], one["other"]) if e.n]
    axis.set(xlim=(max(min([*lows, 0.0]), LOWEST) - 0.03, 1.0), ylim=(-0.6, len(names) - 0.3))
    axis.set_yticks(range(len(names)), [WAYS[name] for name in names])
    axis.set_xlabel("share of the error removed, median and 95 % interval")
    axis.set_title("What looks good on the fitted run, and what is left of it on the next")
    axis.legend(frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.16), ncol=2, fontsize=8)


def _live(axis: Any, arms: list[dict[str, Any]]) -> None:
    done = [one for one in arms if "failed" not in one]
    for row, one in enumerate(done[::-1]):
        before, after = (1e3 * one[when]["joints"] for when in ("before", "after"))
        axis.plot([after, before], [row] * 2, color=LINE, lw=5, solid_capstyle="round", zorder=0)
        axis.plot(before, row, "o", ms=6, color=NOMINAL, label=None if row else "nominal compensator")
        axis.plot(after, row, "o", ms=6, color=FITTED, label=None if row else "with the fitted model")
    axis.set_yticks(range(len(done)), [", ".join(one["effects"]).replace("_", " ") for one in done[::-1]])
    axis.set(xscale="log", ylim=(-0.6, len(done) - 0.4))
    ticks = [x for x in (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50) if _within(axis, x)]
    axis.set_xticks(ticks, [f"{x:g}" for x in ticks], minor=False)
    axis.xaxis.set_minor_locator(_none())
    axis.set_xlabel("true joint angle off the reference [mrad rms]")
    axis.set_title("Concealed arms on the live graph, the same reference twice")
    axis.legend(frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.1), ncol=2, fontsize=8)


def _within(axis: Any, x: float) -> bool:
    low, high = axis.get_xlim()
    return bool(low <= x <= high)


def _none() -> Any:
    from matplotlib.ticker import NullLocator

    return NullLocator()


def draw_comparisons(found: dict[str, Any], arms: list[dict[str, Any]], folder: Path) -> None:
    """Writes proof-trap.png, and proof-live.png where arms ran. found: what `evidence` gives."""
    import matplotlib

    matplotlib.use("Agg")
    style: Any = STYLE
    with matplotlib.rc_context(style):
        save(folder / "proof-trap.png", (8, 3.6), lambda axis: _trap(axis, found["others"]))
        if any("failed" not in one for one in arms):
            size = (8.5, 1.4 + 0.3 * len(arms))
            save(folder / "proof-live.png", size, lambda axis: _live(axis, arms))
