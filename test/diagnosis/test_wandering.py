"""Readings that wander are noise; what goes with the motion, or in steps, is not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from test.diagnosis.arms import NOISE, diagnose, on, recorded
from test.diagnosis.search.looks import fitted
from trunk_ros.diagnosis.data.noise import Noise
from trunk_ros.diagnosis.evidence import wandering as steadying
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.search.slow_noise import is_plain, wandering_in
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


@pytest.mark.parametrize(("arm", "goes"), [("creeping like a rope", False), ("clean", True)])
def test_a_name_that_is_dropped_for_noise_leaves_that_noise(
    monkeypatch: pytest.MonkeyPatch, arm: str, goes: bool
) -> None:
    """In noise that hardly forgets, creep costs next to nothing."""
    times = {"time_constant": 60.0, "time_constant_2": 0.5}
    now = fitted(arm, Term("viscoelastic_creep", "spectrum", own={2: {"gain": 0.03}}, shared=times))
    slow = Noise(NOISE, 0.99, 0.9 * NOISE) if arm != "clean" else now.context.noise[2]
    monkeypatch.setattr(steadying, "is_plain", lambda _, __, ___, column: column != 2)
    monkeypatch.setattr(steadying, "likelier", lambda *_: (slow, 1e3))
    monkeypatch.setattr(steadying, "told", lambda *_: False)

    def held(now: Fit, noise: dict[int, Noise], _: dict[int, Noise]) -> Fit:
        monkeypatch.setattr(steadying, "is_plain", is_plain)
        return costed(wandering_in(now.context, noise), Hypothesis())

    monkeypatch.setattr(steadying, "_held", held)
    assert ("viscoelastic_creep" not in steadying.steadied(now).hypothesis) == goes


def test_levels_between_jumps_are_no_noise() -> None:
    found = seen({}, stepping).findings
    assert [(f.effect, f.joints) for f in found] == [("unknown", ["joint_3"])]
