"""When a finding's regime holds: stretches of time in which what it is about can be seen."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import STILL
from trunk_ros.diagnosis.report.signals import CELLS, reversals
from trunk_ros.recording.signal.gaps import runs

JUST = 0.05  # of the joint's range after a reversal: by then the dead band is crossed
SLOW, FAST = 0.15, 0.6  # of the joint's largest speed
MEANING = {
    "reversal": "the first 5 % of the range after a reversal",
    "low_speed": "moving at less than 15 % of the largest speed",
    "high_speed": "above 60 % of the largest speed",
    "hold": "at rest",
}


def stretches(stamp: Array, angle: Array, regime: str) -> list[tuple[float, float]]:
    """Times [s] between which a regime holds in the motion ``angle`` (n,); none for regimes that hold
    throughout.
    """
    if regime not in MEANING or len(stamp) < 3:
        return []
    return _spans(stamp, _within(regime, stamp, angle))


def _within(regime: str, stamp: Array, angle: Array) -> np.ndarray:
    """(n,) where it holds."""
    speed = np.abs(np.gradient(angle, np.maximum.accumulate(stamp + 1e-9 * np.arange(len(stamp)))))
    top = float(np.quantile(speed, 0.99))
    if regime == "reversal":
        direction, travel = reversals(angle)
        turned = np.cumsum(np.abs(np.diff(direction, prepend=direction[0]))) > 0.0
        return np.asarray(turned & (travel < JUST * float(np.ptp(angle))) & (speed > STILL * top))
    if regime == "low_speed":
        return np.asarray((speed > STILL * top) & (speed < SLOW * top))
    return np.asarray(speed > FAST * top if regime == "high_speed" else speed <= STILL * top)


def _spans(stamp: Array, within: np.ndarray) -> list[tuple[float, float]]:
    """Stretches of a mask (n,), neighbours joined."""
    gap = float(stamp[-1] - stamp[0]) / CELLS  # shorter gaps between stretches are none to the eye
    out: list[tuple[float, float]] = []
    for first, after in runs(within):
        start, end = float(stamp[first]), float(stamp[after - 1])
        if out and start - out[-1][1] < gap:
            out[-1] = (out[-1][0], end)
        else:
            out.append((start, end))
    return out
