"""Readings that say nothing of the joint: a sensor that stuck, and single ones that are far off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.signal.encoder import MEDIAN_TO_STD
from trunk_ros.recording.signal.gaps import usual

STUCK = 5  # equal readings in a row, of a sensor whose readings hardly ever repeat
HARDLY = 0.1  # of the samples, sticking aside
LEAPS = 1.5  # times as far as a joint moves between two samples as a rule
FAR = 12.0  # times the scatter about the readings beside it that a single reading is off
FEW = 0.06  # of the readings: more of them are the sensor's noise


def without_faults(recording: Recording) -> Recording:
    """A recording without such joint readings (they become NaN), and a note on each joint that had some."""
    series = recording.series.get("joint_states")
    if series is None or len(series.stamp) < 10 * STUCK:
        return recording
    position, notes = series.position.copy(), []
    for j, joint in enumerate(series.joints):
        stuck, off = sticks(position[:, j], series.stamp), strays(position[:, j])
        position[stuck | off, j] = np.nan
        if stuck.any():
            begin = series.stamp[np.flatnonzero(stuck)[0]]
            notes.append(
                f"{joint}: its sensor sticks, first at {begin:.2f} s; {stuck.sum()} readings left out"
            )
        if off.any():
            notes.append(f"{joint}: {off.sum()} single readings far from those beside them left out")
    if not notes:
        return recording
    changed = {**recording.series, "joint_states": replace(series, position=position)}
    return replace(recording, series=changed, notes=(*recording.notes, *notes))


def sticks(readings: Array, stamp: Array) -> np.ndarray:
    """(n,) where a sensor repeats one reading for long and leaps when it goes on, at ``stamp`` (n,) s.

    Where readings are missing in between the joint may have gone there.
    """
    out = np.zeros(len(readings), dtype=bool)
    step = np.abs(np.diff(readings))
    same = step == 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(int)))
    runs = [(first, last) for first, last in edges.reshape(-1, 2) if last - first >= STUCK - 1]
    rest = same.sum() - sum(last - first for first, last in runs)
    if not runs or rest > HARDLY * len(same):
        return out
    together = np.diff(stamp) <= usual(stamp)
    far = leap(readings)
    for first, last in runs:
        if last < len(step) and step[last] > far and together[last]:
            out[first + 1 : last + 1] = True
    return out


def strays(readings: Array) -> np.ndarray:
    """(n,) single readings that are far off while those beside them agree."""
    out = np.zeros(len(readings), dtype=bool)
    before, after = readings[1:-3], readings[3:-1]
    beside = np.median([readings[:-4], before, after, readings[4:]], axis=0)
    off = np.abs(readings[2:-2] - beside)
    scatter = MEDIAN_TO_STD * float(np.nanmedian(off))
    out[2:-2] = (off > max(FAR * scatter, leap(readings))) & (np.abs(after - before) < off / 2)
    return out if scatter > 0.0 and out.mean() < FEW else np.zeros_like(out)


def leap(readings: Array) -> float:
    """Further than a joint goes between two readings (n,) that differ."""
    step = np.abs(np.diff(readings))
    return LEAPS * float(np.nanquantile(step[step > 0.0], 0.99)) if (step > 0.0).any() else np.inf
