"""Readings that wander are noise; what goes with the motion, or in steps, is not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from test.diagnosis.arms import NOISE, TRUNK, diagnose, of_the_wires, on, recorded
from test.diagnosis.search.looks import fitted
from trunk_ros.data.align import wire_span
from trunk_ros.data.noise import Noise
from trunk_ros.diagnosis.evidence import wandering as steadying
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.search.of_the_arm import of_the_arm
from trunk_ros.diagnosis.search.slow_noise import is_plain, likeliest_noise, wandering_in
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.recording.recording import Recording

WANDERS, FORGETS = 2.0 * NOISE, 0.97  # rad, from sample to sample


MEASURED = ("joint_1", "joint_3", "joint_5")


def recording_of(effects: dict[str, Any], added: Any) -> Recording:
    """An arm with three joint sensors that add something (n, 3) rad."""
    recording = recorded(effects, 20.0)
    shown = recording.series["joint_states"].select(MEASURED)
    shown = replace(shown, position=shown.position + added(*shown.position.shape))
    return replace(recording, series={**recording.series, "joint_states": shown})


def seen(effects: dict[str, Any], added: Any) -> Diagnosis:
    """The diagnosis of it."""
    return diagnose(of_the_wires(recording_of(effects, added)))


def wandering(rows: int, joints: int) -> np.ndarray:
    steps = np.random.default_rng(5).normal(size=(rows, joints)) * WANDERS * np.sqrt(1.0 - FORGETS**2)
    return np.asarray(lfilter([1.0], [1.0, -FORGETS], steps, axis=0))


def shaking(rows: int, joints: int) -> np.ndarray:
    """A camera that sees all joints."""
    return np.asarray(wandering(rows, 1) * np.ones(joints))


def late(rows: int, joints: int) -> np.ndarray:
    """Stamps of the motors that saw by 4 ms within 7 s."""
    stamp = np.arange(rows) * 0.01
    lag = 4e-3 * (2.0 * (stamp / 7.0 % 1.0) - 1.0)
    moved = recorded({}, 20.0).series["gearbox_states"].select(MEASURED).position * TRUNK.arm.ratio[::2]
    return np.asarray(lag[:, None] * np.gradient(moved, stamp, axis=0))


def stepping(rows: int, joints: int) -> np.ndarray:
    levels = np.repeat(np.random.default_rng(6).normal(size=9) * 8.0 * NOISE, -(-rows // 9))[:rows]
    return np.asarray(levels[:, None] * (np.arange(joints) == 1))


def test_slow_noise_of_sensors_is_noise() -> None:
    said = seen({}, wandering)
    assert said.verdict == "no_mismatch"
    floors = [joint["noise_floor"] for joint in said.stages["wire"]["joints"].values()]
    assert floors == pytest.approx(np.full(3, np.hypot(WANDERS, NOISE)), rel=0.25)
    told = [one for one in said.quality["made"]["observed"] if one["kind"] == "wandering_noise"]
    assert [one["joints"] for one in told] == [(joint,) for joint in MEASURED]
    assert "from sample to sample" in told[0]["statement"]


@pytest.mark.parametrize(("added", "is_of_it"), [(wandering, False), (shaking, True), (late, True)])
def test_what_wanders_with_the_motion_or_on_all_joints_alike_is_of_the_arm(
    added: Any, is_of_it: bool
) -> None:
    context = first_look(WireStage([wire_span(recording_of({}, added), TRUNK)], TRUNK))
    for column in context.columns:
        noise, _ = likeliest_noise(context, Hypothesis(), column)
        assert of_the_arm(context, Hypothesis(), column, noise) == is_of_it


@pytest.mark.long
def test_what_is_of_the_arm_is_not_passed_over_as_noise() -> None:
    said = seen({}, shaking)
    assert said.verdict in ("partly_explained", "unexplained")
    assert not any(one["kind"] == "wandering_noise" for one in said.quality["made"]["observed"])


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
    monkeypatch.setattr(steadying, "of_the_arm", lambda *_: False)

    def held(now: Fit, noise: dict[int, Noise], _: dict[int, Noise]) -> Fit:
        monkeypatch.setattr(steadying, "is_plain", is_plain)
        return costed(wandering_in(now.context, noise), Hypothesis())

    monkeypatch.setattr(steadying, "_held", held)
    assert ("viscoelastic_creep" not in steadying.steadied(now).hypothesis) == goes


def test_levels_between_jumps_are_no_noise() -> None:
    found = seen({}, stepping).findings
    assert [(f.effect, f.joints) for f in found] == [("unknown", ["joint_3"])]
