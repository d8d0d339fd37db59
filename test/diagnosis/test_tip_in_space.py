"""The tip of arms in space: what is built otherwise is named, and what looks the same beside it."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from trunk_ros.arm.description import Description
from trunk_ros.arm.geometry import Geometry, changed
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.tip.judged import fitted_tip, judged_tip
from trunk_ros.diagnosis.tip.stage import ArmProblem
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording

ARMS = Path(__file__).parents[1] / "concealed" / "arms"
PLACE, TURN = 1e-4, 5e-4  # m, rad of noise


@cache
def model_of(name: str) -> Model:
    text = (ARMS / f"{name}.urdf").read_text()
    joints = tuple(joint.name for joint in Description(text).arm_joints)
    return load_model("direct").with_urdf(text, joints)


def motion(model: Model, stamp: Array, seed: int) -> Array:
    rng, arm = np.random.default_rng(seed), model.arm
    out = np.zeros((len(stamp), len(arm.joints)))
    for j in range(out.shape[1]):
        for _ in range(3):
            out[:, j] += np.sin(2 * np.pi * rng.uniform(0.03, 0.3) * stamp + rng.uniform(0, 6))
    return np.asarray(
        (arm.lower + arm.upper) / 2 + 0.4 * (arm.upper - arm.lower) * out / np.abs(out).max(axis=0)
    )


def seen(name: str, effects: dict[str, Any], seed: int = 1) -> Recording:
    rng, model, stamp = np.random.default_rng(seed), model_of(name), np.arange(1500) / 50.0
    theta = motion(model, stamp, seed)
    tip = Chain(Model(model.arm, effects), "arm").tip(theta, stamp)
    place = tip[:, :3] + PLACE * rng.normal(size=(len(tip), 3))
    turn = Rotation.from_rotvec(TURN * rng.normal(size=(len(tip), 3))) * Rotation.from_quat(tip[:, 3:])
    series = {"joint_states": JointSeries(stamp, model.arm.joints, theta)}
    return Recording(name, 0, float(stamp[-1]), series, PoseSeries(stamp, place, turn.as_quat()))


def problem(recording: Recording) -> ArmProblem:
    found = fitted_tip([recording], model_of(recording.name), 0.0, {})
    assert found is not None
    return found[0]


def told(recording: Recording) -> tuple[dict[str, Any], list[Finding], dict[str, Any]]:
    found = fitted_tip([recording], model_of(recording.name), 0.0, {})
    assert found is not None
    return judged_tip(*found)


def on(joints: int, joint: int, value: float) -> Array:
    return np.where(np.arange(joints) == joint, value, 0.0)


CASES: list[tuple[str, dict[str, Any], dict[str, list[str]]]] = [
    ("six", {}, {}),
    ("scara", {}, {}),
    ("six", {"link_length_error": {"length_error": on(6, 1, 2e-3)}}, {"link_length_error": ["j2"]}),
    ("seven", {"link_offset_error": {"across_1": on(7, 2, 2e-3)}}, {"link_offset_error": ["a3"]}),
    ("six", {"axis_tilt": {"tilt_1": on(6, 2, 6e-3)}}, {"axis_tilt": ["j3"]}),
    ("seven", {"joint_zero_error": {"offset": on(7, 3, 6e-3)}}, {"joint_zero_error": ["a4"]}),
    ("three", {"base_tilt": {"angle": 3e-3, "angle_y": -4e-3}}, {"base_tilt": []}),
    ("scara", {"base_shift": {"x": 3e-3, "z": -2e-3}}, {"base_shift": []}),
    ("three", {"tool_offset": {"x": 2e-3, "z": -1e-3, "pitch": 6e-3}}, {"tool_offset": []}),
    ("wrist", {"tip_delay": {"delay": 0.01}}, {"tip_delay": []}),
    ("six", {"link_compliance": {"compliance": on(6, 1, 4e-3)}}, {"link_compliance": ["j2"]}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "effects", "expected"), CASES, ids=lambda each: str(list(each))[:40])
def test_what_is_built_otherwise_is_named_on_its_joint(
    name: str, effects: dict[str, Any], expected: dict[str, list[str]]
) -> None:
    stage, found, model = told(seen(name, effects))
    assert {f.effect: f.joints for f in found} == expected
    assert set(stage["tip"]) == {"x", "y", "z", "roll", "pitch", "yaw"}
    assert all(each["rmse_after"] < 1.2 * each["noise_floor"] for each in stage["tip"].values())
    for effect, values in effects.items():
        for parameter, value in values.items():
            scale = np.abs(value).max()
            assert model[effect][parameter] == pytest.approx(value, abs=0.1 * scale)


@pytest.mark.filterwarnings("error")
def test_a_tip_without_any_noise_is_judged_as_others_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "PLACE", 0.0)
    monkeypatch.setitem(globals(), "TURN", 0.0)
    stage, found, _ = told(seen("scara", {"link_length_error": {"length_error": on(4, 1, 2e-3)}}))
    assert [finding.effect for finding in found] == ["link_length_error"]
    assert all(signal["noise_floor"] > 0.0 for signal in stage["tip"].values())


def test_a_zero_of_the_last_joint_may_be_a_tool_that_is_turned() -> None:
    _, (found,), _ = told(seen("six", {"joint_zero_error": {"offset": on(6, 5, 8e-3)}}))
    assert (found.effect, found.joints, found.equivalents) == ("joint_zero_error", ["j6"], ["tool_offset"])
    assert found.confidence < 0.8


def test_a_link_behind_the_last_joint_is_the_tools_place() -> None:
    _, found, _ = told(seen("seven", {"link_offset_error": {"across_2": on(7, 6, 2e-3)}}))
    assert {f.effect for f in found} == {"tool_offset"}
    assert "link_offset_error" in found[0].equivalents


def test_without_orientations_the_place_is_enough_for_a_length() -> None:
    recording = seen("six", {"link_length_error": {"length_error": on(6, 1, 2e-3)}})
    assert recording.tip is not None
    recording.tip.orientation[:] = [0.0, 0.0, 0.0, 1.0]
    stage, found, _ = told(recording)
    assert set(stage["tip"]) == {"x", "y", "z"}
    assert [(f.effect, f.joints) for f in found] == [("link_length_error", ["j2"])]


@pytest.mark.parametrize("name", ["six", "scara"])
def test_slopes_are_those_of_the_tip_itself(name: str) -> None:
    """By differences of predictions, for every value of the arm's geometry."""
    made = problem(seen(name, {}))
    made.linearise({})
    rows = slice(0, 40)
    for key, column in made._column.items():
        step = 1e-2 * made.linear.step[column]
        after, before = (np.concatenate(made.residual({key: way * step}))[rows] for way in (1, -1))
        slope = (before - after) / (2 * step)
        mine = made.linear.slopes[rows, :, column] / made.linear.step[column]
        assert mine == pytest.approx(slope, abs=2e-3 * np.abs(slope).max() + 1e-9), key


def test_a_tilted_axis_leaves_the_arm_at_0_where_it_is() -> None:
    arm = model_of("six").arm
    geometry = Geometry.nominal(6)
    geometry.tilt[2] = [0.01, 0.0, 0.02]
    tilted, zero = changed(arm.body, geometry), np.zeros((1, 6))
    assert tilted.poses(zero) == pytest.approx(arm.tip(zero), abs=1e-12)
    bent = zero + on(6, 2, 0.7)
    assert np.abs(tilted.poses(bent) - arm.tip(bent))[:, :3].max() > 1e-3
