"""``diagnose`` and ``simulate`` refuse bad input in one line, and leave nothing half-written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import on, recorded, reshaped
from test.diagnosis.made import backlash
from trunk_ros.__main__ import main
from trunk_ros.commands.diagnose import spoken
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "bag"
    write_recording(path, recorded({"backlash": {"half_width": on(2, 8e-4)}}, 20.0))
    return path


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(arguments) == 2
    said = capsys.readouterr().err.strip()
    assert len(said.splitlines()) == 1
    return said


def without(recording: Recording, *keys: str) -> Recording:
    for key in keys:
        recording.series.pop(key)
    return recording


def test_diagnose_writes_its_three_files_and_the_model_runs(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, predicted = tmp_path / "out", tmp_path / "predicted"
    assert main(["diagnose", str(bag), "--output", str(out)]) == 0
    written = {p.name for p in out.iterdir()}
    assert written - {"experiment_wire.yaml"} == {"diagnosis.json", "model.yaml", "report.html"}
    assert "backlash" in capsys.readouterr().out
    assert main(["simulate", str(bag), "--model", str(out / "model.yaml"), "--output", str(predicted)]) == 0
    shown = read_recording(predicted).series["joint_states"]
    assert np.array_equal(shown.stamp, read_recording(bag).series["joint_states"].stamp)


@pytest.mark.filterwarnings("error")
def test_a_single_sample_is_refused_as_too_short_and_no_more_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = JointSeries(np.zeros(1), ("elbow",), np.zeros((1, 1)))
    series = dict.fromkeys(("setpoints", "gearbox_states", "joint_states"), one)
    write_recording(tmp_path / "one", Recording("one", 0, 0.0, series))
    said = refused(["diagnose", str(tmp_path / "one"), "-m", "direct", "-o", str(tmp_path / "out")], capsys)
    assert "over a longer time" in said


def test_simulate_from_setpoints_predicts_the_gearbox_as_well(bag: Path, tmp_path: Path) -> None:
    out = tmp_path / "predicted"
    assert main(["simulate", str(bag), "--model", "trunk", "--from", "setpoints", "--output", str(out)]) == 0
    phi = read_recording(out).series["gearbox_states"].position
    assert np.abs(phi - read_recording(bag).series["gearbox_states"].position)[100:].max() < 1e-4


def test_an_output_that_exists_is_refused(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "exists" in refused(["diagnose", str(bag), "--output", str(tmp_path)], capsys)


def test_a_number_of_cores_that_is_none_is_refused(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for cores in ("0", "-1", "two"):
        said = refused(["diagnose", str(bag), "--cores", cores, "--output", str(tmp_path / "new")], capsys)
        assert "whole number" in said


def test_a_bag_without_the_topic_is_refused_naming_those_it_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_recording(tmp_path / "bag", without(recorded(seconds=5.0), "gearbox_states"))
    said = refused(["diagnose", str(tmp_path / "bag"), "--output", str(tmp_path / "out")], capsys)
    assert "no topic trunk/gearbox_states" in said
    assert "topics there: " in said
    assert "joint_states" in said
    assert not (tmp_path / "out").exists()


def test_joints_that_the_arm_does_not_have_are_refused_naming_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = recorded(seconds=5.0)
    for key in ("gearbox_states", "joint_states", "setpoints"):
        recording = reshaped(recording, key, joints=("a", "b", "c", "d", "e"))
    write_recording(tmp_path / "bag", recording)
    said = refused(["diagnose", str(tmp_path / "bag"), "--output", str(tmp_path / "out")], capsys)
    assert "joint_1" in said
    assert "a, b" in said


def test_an_unwritable_place_is_refused_and_nothing_is_left(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    refused(["diagnose", str(bag), "--output", str(tmp_path / "file" / "out")], capsys)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_model_that_is_not_there_is_refused_naming_the_choices(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = refused(["simulate", str(bag), "--model", "nowhere", "--output", str(tmp_path / "out")], capsys)
    assert "trunk" in said
    assert "direct" in said


def test_pairs_that_no_motion_decides_take_one_line_and_a_motion_is_told_in_full() -> None:
    result = backlash()
    result.experiments += [
        {
            "separates": ["backlash", "stribeck_friction"],
            "statement": "Play it.",
            "trajectory": "motion.yaml",
        },
        {"separates": ["backlash", ["ratio_error", "zero_offset"]], "statement": "Long.", "trajectory": ""},
        {"separates": ["sensor_delay", "viscous_lag"], "statement": "Longer.", "trajectory": ""},
    ]
    assert spoken(result)[-2:] == [
        "  experiment: Play it.",
        "  no motion that was tried decides between backlash and ratio_error + zero_offset, or "
        "sensor_delay and viscous_lag",
    ]


def test_statements_of_what_a_simulation_has_are_joined_without_their_full_stops() -> None:
    result = backlash()
    result.simulator, result.simulation = result.model, {"has": ["elbow: backlash.", "wrist: a delay."]}
    assert spoken(result)[0] == "your simulation has: elbow: backlash; wrist: a delay"
