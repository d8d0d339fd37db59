"""Errors of predictions, in the signal's unit and in noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import is_none, noise_of, strides_within
from trunk_ros.evaluate.signals import Signal
from trunk_ros.evaluate.source import Prediction
from trunk_ros.recording.signal.encoder import count

SCHEMA = "trunk_ros/evaluate/1"
SETTLE = 5.0  # s at the start that do not count: where the play stood is not known
MOST_SETTLING = 0.25  # of a recording
LEAST = 10  # samples


@dataclass(frozen=True)
class Row:
    """One signal of one recording under one model; errors and noise in ``unit``, rms over what counts."""

    recording: str
    model: str
    stage: str
    joint: str
    unit: str
    rms_before: float
    rms_after: float
    worst_before: float
    worst_after: float
    noise: float

    @property
    def in_noise(self) -> float:
        """The rms error after, in noise."""
        return self.rms_after / self.noise

    @property
    def has_noise(self) -> bool:
        """Whether there is any noise to speak of."""
        return not is_none(self.noise)


def score(recording: str, predictions: Sequence[Prediction], settle: float = SETTLE) -> list[Row]:
    """Rows of one recording; ``settle`` s at the start do not count, at most a quarter of it.

    A signal's noise is the least that any of the predictions leaves it, so that it is the same in all rows.
    """
    noise: dict[tuple[str, str], float] = {}
    for signal in (signal for prediction in predictions for signal in prediction.after):
        seen = _noise(signal, _counted(signal.stamp, settle))
        noise[signal.stage, signal.name] = min(seen, noise.get((signal.stage, signal.name), np.inf))
    return [row for prediction in predictions for row in _rows(recording, prediction, settle, noise)]


def _rows(
    recording: str, prediction: Prediction, settle: float, noise: dict[tuple[str, str], float]
) -> Iterator[Row]:
    before = {(signal.stage, signal.name): signal for signal in prediction.before}
    for signal in prediction.after:
        key = signal.stage, signal.name
        keep = _counted(signal.stamp, settle)
        if np.isfinite(signal.error[keep]).sum() < LEAST:
            continue
        rms_after, worst_after = _size(signal.error[keep])
        first = before.get(key, signal)
        rms_before, worst_before = _size(first.error[_counted(first.stamp, settle)])
        yield Row(
            recording, prediction.name, *key, signal.unit, rms_before, rms_after, worst_before, worst_after,
            noise[key],
        )  # fmt: skip


def _counted(stamp: Array, settle: float) -> np.ndarray:
    return np.asarray(stamp >= stamp[0] + min(settle, MOST_SETTLING * (stamp[-1] - stamp[0])))


def _size(error: Array) -> tuple[float, float]:
    """Rms and largest of what is known."""
    known = error[np.isfinite(error)]
    if not len(known):
        return np.nan, np.nan
    return float(np.sqrt(np.mean(known**2))), float(np.abs(known).max())


def _noise(signal: Signal, keep: np.ndarray) -> float:
    """Standard deviation of the sensor's noise, an encoder's steps at least."""
    error, known = signal.error[keep], np.isfinite(signal.error[keep])
    if known.sum() < LEAST:
        return np.inf
    step = float(np.median(np.diff(signal.stamp)))
    seen = noise_of([np.where(known, error, 0.0)], [known], strides_within(step)).std
    return max(seen, float(count(signal.measured[keep][known]) / np.sqrt(12.0)))


def to_json(rows: Sequence[Row]) -> dict[str, Any]:
    """What ``evaluate --json`` prints."""
    return {"schema": SCHEMA, "rows": [asdict(row) for row in rows]}
