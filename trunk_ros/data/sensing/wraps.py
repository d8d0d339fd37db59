"""Readings that jump by a whole turn where a sensor's range ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.levels import PART
from trunk_ros.recording.recording import JointSeries

TURN = 2.0 * np.pi


def unwrapped(readings: Array) -> tuple[Array, int]:
    """Readings (n,) rad of an angle without jumps of whole turns, and how many there were.

    A joint that moves so far between samples as a rule that a turn is no jump stays as it is. NaN stays NaN.
    """
    known = np.isfinite(readings)
    steps = np.diff(readings[known])
    turns = np.rint(steps / TURN)
    jumps = (turns != 0.0) & (np.abs(steps - TURN * turns) < PART * TURN)
    if not jumps.any() or jumps.all() or np.quantile(np.abs(steps[~jumps]), 0.999) > 2.0 * PART * TURN:
        return readings, 0
    out = readings.copy()
    out[known] -= TURN * np.concatenate([[0.0], np.cumsum(np.where(jumps, turns, 0.0))])
    return out, int(jumps.sum())


def series_unwrapped(series: JointSeries, angles: np.ndarray) -> tuple[JointSeries, dict[str, int]]:
    """The series with its ``angles`` (joints,) unwrapped, and by joint how often each had jumped."""
    position = series.position.copy()
    found: dict[str, int] = {}
    for j, joint in enumerate(series.joints):
        if angles[j]:
            position[:, j], times = unwrapped(position[:, j])
            found |= {joint: times} if times else {}
    return (replace(series, position=position) if found else series), found


def whole_turns(apart: Array) -> float:
    """Whole turns [rad] by which two courses (n,) of one angle are apart, 0 where they are not; they may have
    been counted from another one.
    """
    known = apart[np.isfinite(apart)]
    middle = float(np.median(known)) if len(known) else 0.0
    turns = TURN * round(middle / TURN)
    return float(turns) if abs(middle - turns) < PART * TURN else 0.0
