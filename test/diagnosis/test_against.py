"""Another simulator is known by its own recording; findings are what it lacks, or has too much of."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, setpoints_of
from trunk_ros.chain import Chain
from trunk_ros.diagnosis import Diagnosis
from trunk_ros.diagnosis.report.page import render
from trunk_ros.diagnosis.simulators.against import with_room
from trunk_ros.diagnosis.simulators.other_simulator import sides_told
from trunk_ros.diagnosis.verdict.differences import known_of
from trunk_ros.diagnosis.verdict.finding import Finding, evidence_of
from trunk_ros.diagnosis.verdict.findings import value_of
from trunk_ros.errors import RecordingError
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

JOINTS = ("shoulder", "elbow", "wrist")
RATIO, DEAD_BAND, DELAY = 1.03, 4e-3, 0.03
TRUTH = {
    "ratio_error": {"relative": np.array([RATIO - 1, 0.0, 0.0])},
    "backlash": {"half_width": np.array([0.0, DEAD_BAND, 2e-3])},
    "sensor_delay": {"delay": DELAY},
}


def run(effects: dict[str, Any], noise: float) -> Recording:
    """An arm whose joints have names of their own, motor side and joint side."""
    direct = load_model("direct").for_joints(JOINTS)
    phi = setpoints_of(12.0, len(JOINTS))
    stamp = np.arange(len(phi)) / 100
    theta, _ = Chain(Model(direct.arm, effects), "wire").run(phi, stamp)
    theta = theta + noise * np.random.default_rng(0).standard_normal(theta.shape)
    series = {
        "gearbox_states": JointSeries(stamp, JOINTS, phi),
        "joint_states": JointSeries(stamp, JOINTS, theta),
    }
    return Recording("run", 1_750_000_000_000_000_000, float(stamp[-1]), series)


def found(simulated: dict[str, Any]) -> Diagnosis:
    """The arm against a simulator with some effects, without a word on either."""
    return diagnose([run(TRUTH, 1e-4)], against=run(simulated, 0.0))


def total(result: Diagnosis) -> dict[str, np.ndarray]:
    """What the model says of the arm, whatever the simulator has."""
    effects, arm = result.model.effects, result.model.arm
    relative = effects.get("ratio_error", {}).get("relative", np.zeros(3))
    return {
        "ratio": arm.ratio * (1 + relative),
        "dead_band": arm.dead_band + effects["backlash"]["half_width"],
        "delay": np.array(effects["sensor_delay"]["delay"]),
    }


SIMULATORS: dict[str, dict[str, Any]] = {
    "nothing": {},
    "some": {"backlash": {"half_width": np.array([0.0, 2e-3, 0.0])}},
    "all": TRUTH,
    "too much": {
        "ratio_error": {"relative": np.full(3, 0.05)},
        "backlash": {"half_width": np.array([3e-3, 7e-3, 0.0])},
        "sensor_delay": {"delay": 0.05},
    },
}


@pytest.mark.parametrize("name", ["nothing", "some"])
def test_the_same_arm_comes_out_whatever_the_simulator_has(name: str) -> None:
    result = found(SIMULATORS[name])
    said = total(result)
    assert said["ratio"] == pytest.approx([RATIO, 1.0, 1.0], abs=1e-3)
    assert said["dead_band"] == pytest.approx([0.0, DEAD_BAND, 2e-3], abs=1e-4)
    assert said["delay"] == pytest.approx(DELAY, abs=5e-4)
    assert {f.effect for f in result.findings} <= {"ratio_error", "backlash", "sensor_delay"}


def test_what_the_simulator_has_itself_is_no_finding() -> None:
    result = found(TRUTH)
    assert (result.verdict, result.findings) == ("no_mismatch", [])
    assert len(result.simulation["has"]) == 3


@pytest.mark.long
def test_a_recording_against_itself_lacks_nothing() -> None:
    """What no name fits, in the servos of both, had been a finding at 0.95."""
    whole = run({}, 0.0)
    made = replace(whole, series={key: series.select(JOINTS[:1]) for key, series in whole.series.items()})
    shown, stamp = made.series["gearbox_states"], made.series["gearbox_states"].stamp
    bend = 0.004 * np.sin(0.9 * stamp) * np.exp(-(((stamp - 7.0) / 2.5) ** 2))
    asked = replace(shown, position=shown.position - bend[:, None], velocity=None)
    both = replace(made, series={**made.series, "setpoints": asked})
    result = diagnose([both], against=both)
    assert any(" no name " in words for words in result.simulation["has"])
    assert (result.verdict, result.findings) == ("no_mismatch", [])


@pytest.mark.long
def test_too_much_of_an_effect_has_a_negative_size_and_says_so(tmp_path: Path) -> None:
    result = found(SIMULATORS["too much"])
    (backlash,) = (f for f in result.findings if f.effect == "backlash")
    (delay,) = (f for f in result.findings if f.effect == "sensor_delay")
    missing = {joint: values["half_width"]["value"] for joint, values in backlash.parameters.items()}
    assert missing == pytest.approx({"shoulder": -3e-3, "elbow": -3e-3, "wrist": 2e-3}, abs=1e-4)
    assert delay.parameters["arm"]["delay"]["value"] == pytest.approx(-0.02, abs=5e-4)
    assert (
        "elbow: your simulation has 7 mrad, the recording shows 4 mrad (3 mrad too much)"
        in backlash.statement
    )
    assert "shoulder: your simulation has 3 mrad, the recording shows none" in backlash.statement
    page = render(result)
    assert "Your simulation has:" in page
    assert re.search("less [^<]*sensor delay", page)
    result.save(tmp_path)
    own = load_model(tmp_path / "simulation.yaml")
    assert own.arm.ratio == pytest.approx([1.05] * 3, abs=1e-3)
    assert own.effects["backlash"]["half_width"] == pytest.approx([3e-3, 7e-3, 0.0], abs=1e-4)
    (tmp_path / "report.html").write_text(page)


@pytest.mark.parametrize("ours", [False, True])
def test_a_bag_with_the_joints_for_the_motor_side_is_told_beside_one_with_a_gear(ours: bool) -> None:
    plain, geared = run({}, 0.0), run({"ratio_error": {"relative": np.full(3, -0.5)}}, 1e-4)
    shown = geared.series["joint_states"]
    plain = replace(plain, name="sim", series={"gearbox_states": shown, "joint_states": shown})
    one, other = (plain, geared) if ours else (geared, plain)
    (note,) = sides_told(one, other).notes
    assert "sim has the same angles for motor side and joint on shoulder, elbow, wrist" in note
    assert "in run shoulder turns by 0.5 of its motor" in note
    assert sides_told(geared, geared).notes == ()
    assert sides_told(plain, run(TRUTH, 1e-4)).notes == ()


def test_a_simulator_without_the_arms_joints_is_refused() -> None:
    other = run({}, 0.0)
    renamed = {key: replace(each, joints=("a", "b", "c")) for key, each in other.series.items()}
    with pytest.raises(RecordingError, match="no joint_states of shoulder, elbow, wrist"):
        diagnose([run(TRUTH, 1e-4)], against=replace(other, series=renamed))


def test_a_simulator_that_is_faster_than_the_models_motors_has_no_top_speed_of_theirs() -> None:
    model, slow = load_model("direct").for_joints(JOINTS), run({}, 0.0)
    assert with_room(model, [slow]) is model
    fast = replace(slow, series={k: replace(v, stamp=v.stamp / 8) for k, v in slow.series.items()})
    phi = fast.series["gearbox_states"]
    quickest = np.abs(np.diff(phi.position, axis=0)).max() / np.median(np.diff(phi.stamp))
    assert quickest > model.arm.v_max
    assert with_room(model, [slow, fast]).arm.v_max > 5 * quickest


def _of(name: str, sizes: dict[str, tuple[float, float]], parameter: str, unit: str) -> Finding:
    """A finding with a value and its spread by joint."""
    told = {joint: {parameter: value_of(size, std, unit)} for joint, (size, std) in sizes.items()}
    return Finding(name, "wire", [*sizes], "always", 0.9, [], told, [], "as it was", evidence_of(form=""))


def test_a_size_that_is_not_known_apart_from_nothing_is_not_listed() -> None:
    """Offsets of 2e-07 +- 5.5e-05 had been told as what the simulation has."""
    offsets = {"shoulder": (2e-7, 5.5e-5), "elbow": (4e-3, 5e-5)}
    said = known_of(_of("zero_offset", offsets, "offset", "rad"))
    assert said.startswith("elbow: ")
    assert "shoulder" not in said
    assert known_of(_of("zero_offset", {"shoulder": offsets["shoulder"]}, "offset", "rad")) == ""
    unnamed = _of("unknown", {}, "", "")
    assert known_of(unnamed) == "as it was"
