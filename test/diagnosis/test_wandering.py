"""Readings that wander are noise; what goes with the motion, or in steps, is not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from test.diagnosis.arms import NOISE, diagnose, on, recorded
from trunk_ros.diagnosis.verdict.result import Diagnosis

WANDERS, FORGETS = 2.0 * NOISE, 0.97  # rad, from sample to sample


MEASURED = ("joint_1", "joint_3", "joint_5")


def seen(effects: dict[str, Any], added: Any) -> Diagnosis:
    """The diagnosis of an arm with three joint sensors that add something (n, 3) rad."""
    recording = recorded(effects, 20.0)
    shown = recording.series["joint_states"].select(MEASURED)
    shown = replace(shown, position=shown.position + added(*shown.position.shape))
    return diagnose(replace(recording, series={**recording.series, "joint_states": shown}))


def wandering(rows: int, joints: int) -> np.ndarray:
    steps = np.random.default_rng(5).normal(size=(rows, joints)) * WANDERS * np.sqrt(1.0 - FORGETS**2)
    return np.asarray(lfilter([1.0], [1.0, -FORGETS], steps, axis=0))


def stepping(rows: int, joints: int) -> np.ndarray:
    levels = np.repeat(np.random.default_rng(6).normal(size=9) * 8.0 * NOISE, -(-rows // 9))[:rows]
    return np.asarray(levels[:, None] * (np.arange(joints) == 1))


def test_slow_noise_of_sensors_is_noise() -> None:
    said = seen({}, wandering)
    assert said.verdict == "no_mismatch"
    floors = [joint["noise_floor"] for joint in said.stages["wire"]["joints"].values()]
    assert floors == pytest.approx(np.full(3, np.hypot(WANDERS, NOISE)), rel=0.25)


def test_beside_it_what_is_missing_is_found() -> None:
    found = seen({"backlash": {"half_width": on(3, 2e-3)}}, wandering).findings
    assert [(f.effect, f.joints) for f in found] == [("backlash", ["joint_3"])]


def test_levels_between_jumps_are_no_noise() -> None:
    found = seen({}, stepping).findings
    assert [(f.effect, f.joints) for f in found] == [("unknown", ["joint_3"])]
