"""What the interactive plots draw: each signal thinned to what a screen can show, and the regimes."""

from __future__ import annotations

import base64
from itertools import pairwise
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.report.errors import culprit_spans, loudest, shown_over_time
from trunk_ros.diagnosis.report.regimes import MEANING, stretches
from trunk_ros.diagnosis.report.signals import CELLS, Signal, concerns, joint_angle, signals
from trunk_ros.diagnosis.report.style import label
from trunk_ros.diagnosis.report.units import multiple, spoken
from trunk_ros.diagnosis.verdict.answer import Answer

FIRST = 2  # signals that are open when the page is
MOST = 24  # signals that the page holds; an arm of more joints has its loudest


def series(result: Answer) -> dict[str, Any]:
    """For the page's script, as JSON. Curves are float32, base64. Residuals, nominal first, stand in for the
    predictions: a difference of angles in float32 would show steps.
    """
    loud = shown_over_time(result)
    every = [s for s in signals(result) if len(s.stamp) > 1 and s.valid.any()]
    kept = every if len(every) <= MOST else [s for s in every if any(s is k for k in loud)] or every[:MOST]
    open_ = {(s.stage, s.name) for s in loudest(result, loud)[:FIRST]}
    return {"signals": [_signal(result, s, (s.stage, s.name) in open_) for s in kept]}


def _signal(result: Answer, signal: Signal, is_open: bool) -> dict[str, Any]:
    rows = thinned(signal)
    angle = np.where(np.isfinite(signal.measured), signal.measured, np.nan).astype(float)
    errors = [signal.error_before, *([signal.error_after] if signal.changed else [])]
    size = max(float(np.nanmax(np.abs(e), initial=0.0)) for e in errors)
    factor, unit = multiple(float(np.nanmax(np.abs(angle), initial=0.0)), signal.unit)
    small, small_unit = multiple(size, signal.unit)
    return {
        "name": f"{signal.stage} · {label(signal.name)}",
        "open": is_open,
        "quantity": "position" if signal.unit == "m" else "angle",
        "unit": unit,
        "residual_unit": small_unit,
        "time": _packed(signal.stamp[rows]),
        "measured": _packed(factor * angle[rows]),
        "residuals": [_packed(small * error[rows]) for error in errors],
        "scale": factor / small,
        "noise": small * signal.noise,
        "regimes": _regimes(result, signal),
    }


def _regimes(result: Answer, signal: Signal) -> list[dict[str, Any]]:
    """Of the findings on a signal, by regime, with the stretches of time; culprits where none is bounded."""
    names: dict[str, list[str]] = {}
    for finding in result.findings:
        if concerns(finding, signal.stage, signal.name):
            names.setdefault(finding.regime, []).append(spoken(finding.effect))
    angle = joint_angle(result, signal)
    out = [
        {"what": f"{', '.join(effects)}: {MEANING[regime]}", "spans": spans}
        for regime, effects in names.items()
        if angle is not None and (spans := stretches(signal.stamp, angle, regime))
    ]
    throughout = [effect for regime, effects in names.items() if regime not in MEANING for effect in effects]
    if throughout:
        what = f"{', '.join(throughout)}: nominal residual well above the noise"
        out.append({"what": what, "spans": culprit_spans(signal)})
    return out


def thinned(signal: Signal) -> np.ndarray:
    """Rows, in order: of each cell of time those at which a curve is lowest or highest, and the cell's ends.

    So no spike is lost, and zooming in shows every curve at the same stamps.
    """
    cells = np.unique(np.linspace(0, len(signal.stamp), CELLS + 1).astype(int))
    kept = [cells[:-1], cells[1:] - 1]
    for values in (signal.measured, signal.error_before, signal.error_after if signal.changed else None):
        if values is not None:
            kept += [_extremes(values, cells, sign) for sign in (1.0, -1.0)]
    return np.unique(np.concatenate(kept))


def _extremes(values: Array, cells: np.ndarray, sign: float) -> np.ndarray:
    """Row of the largest of ``sign * values`` in each cell."""
    known = np.where(np.isfinite(values), sign * values, -np.inf)
    return np.array([a + int(np.argmax(known[a:b])) for a, b in pairwise(cells)])


def _packed(values: Array) -> str:
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")
