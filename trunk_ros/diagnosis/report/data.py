"""What the page says of the data and of where it comes from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from trunk_ros.diagnosis.evidence.cross_validation import BLOCKS
from trunk_ros.diagnosis.report.signals import Signal, entries, largest, signals
from trunk_ros.diagnosis.report.units import quantity
from trunk_ros.diagnosis.verdict.answer import STAGES, Answer
from trunk_ros.words import significant

SAME = "same"
LEAST_SPEED = 1e-3  # of the range per second, on average: slower than this nothing can be said of a lag


def recordings(result: Answer) -> list[dict[str, Any]]:
    """Duration, topics and notes of each recording."""
    return [
        {
            "name": name,
            "duration": _length(held),
            "topics": [_topic(topic, said) for topic, said in held.get("topics", {}).items()],
            "notes": [str(note) for note in held.get("notes", ())],
        }
        for name, held in result.quality.items()
    ]


def _length(held: dict[str, Any]) -> str:
    """How long a recording is, and which part of it was asked for."""
    whole = f"{_plain(held.get('duration', 0.0))} s"
    return f"{_plain(held['from'])} to {_plain(held['until'])} s of {whole}" if "until" in held else whole


def _plain(seconds: float) -> str:
    """Hundredths at most, and no exponent, however long."""
    return f"{float(seconds):.2f}".rstrip("0").rstrip(".")


def _topic(name: str, said: dict[str, Any]) -> dict[str, Any]:
    period = float(said.get("period") or 0.0)
    odd = {"duplicates": "duplicates", "out_of_order": "out of order", "not_finite": "not finite",
           "unreadable": "unreadable"}  # fmt: skip
    longest = quantity(float(said.get("longest_gap") or 0.0), None, "s")
    jitter = float(said.get("jitter") or 0.0)
    gaps = int(said.get("gaps") or 0)
    return {
        "name": name,
        "samples": said.get("samples", 0),
        "rate": f"{significant(1 / period)} Hz" if period else "–",
        "jitter": quantity(jitter, None, "s") if jitter > 1e-6 else "none",
        "lost": "–" if said.get("lost") is None else str(said["lost"]),
        "gaps": f"{gaps}, longest {longest} at {float(said.get('gap_at') or 0.0):.1f} s" if gaps else "none",
        "odd": ", ".join(f"{said[key]} {word}" for key, word in odd.items() if said.get(key)) or "nothing",
    }


def numbers(result: Answer) -> list[dict[str, str]]:
    """Of each signal: errors on unseen data, noise floor, encoder steps, samples that count, apparent lag."""
    kept = {(s.stage, s.name): s for s in signals(result)}
    return [
        {
            "signal": f"{stage} · {name}",
            **_errors(said, largest(result, stage, str(said.get("unit", "rad")))),
            **_samples(kept.get((stage, name))),
        }
        for stage in STAGES
        for name, said in entries(result, stage).items()
    ]


def _errors(said: dict[str, Any], size: float) -> dict[str, str]:
    unit = str(said.get("unit", "rad"))
    before, after = (
        quantity(said.get(f"rmse_{when}"), said.get(f"rmse_{when}_std"), unit, size=size)
        for when in ("before", "after")
    )
    noise, steps = (quantity(said.get(key), None, unit, size=size) for key in ("noise_floor", "resolution"))
    return {"before": before, "after": SAME if after == before else after, "noise": noise, "steps": steps}


def _samples(signal: Signal | None) -> dict[str, str]:
    if signal is None:
        return {"samples": "–", "lag_before": "–", "lag_after": "–"}
    return {
        "samples": f"{int(signal.valid.sum())} of {len(signal.valid)}",
        "lag_before": _lag(signal, signal.before, signal.error_before),
        "lag_after": _lag(signal, signal.after, signal.error_after) if signal.changed else SAME,
    }


def _lag(signal: Signal, predicted: np.ndarray, error: np.ndarray) -> str:
    """Time by which what was measured trails what was predicted: the error over the slope, least squares.
    Where that is less than its spread, how large it may be.
    """
    if len(signal.stamp) < 3:
        return "–"
    slope = np.gradient(predicted, signal.stamp)
    known = np.isfinite(error) & np.isfinite(slope)
    power = float(np.sum(slope[known] ** 2))
    moved = float(np.ptp(predicted)) * LEAST_SPEED
    if not known.any() or power <= moved**2 * known.sum() or power == 0.0:
        return "–"
    lag = -float(np.sum(error[known] * slope[known])) / power
    off = np.where(known, (error + lag * slope) * slope, 0.0)
    blocks = [float(block.sum()) for block in np.array_split(off, BLOCKS)]
    spread = float(np.sqrt(np.sum(np.square(blocks)))) / power
    if abs(lag) < 2 * spread:
        return f"under {significant(1e3 * (abs(lag) + 2 * spread), 2)} ms"
    return f"{round(1e3 * lag, 2) + 0.0:.2f} ± {2e3 * spread:.2f} ms".replace("-", "−")


def provenance(result: Answer) -> list[tuple[str, str]]:
    """Command, versions and hashes as lines of text; the fitted model's hash among them."""
    told = {
        key: value for key, value in result.provenance.items() if key != "arguments"
    }  # the command has them
    lines = [(key if key == "trunk_ros" else key.replace("_", " "), value) for key, value in _flat(told)]
    return [*lines, ("fitted model hash", result.model.hash())]


def _flat(held: dict[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    for key, value in held.items():
        name = f"{above} {key}".strip()
        if isinstance(value, dict):
            yield from _flat(value, name)
        else:
            yield name, ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
