"""``info``: what it says of recordings that need something before they can be diagnosed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import recorded
from test.diagnosis.test_tip_in_space import ARMS, seen
from test.recording.bags import motion, pose, write_bag
from test.test_pages_run import an_old_bag
from trunk_ros.__main__ import main
from trunk_ros.commands.info import foreign, gathered, model_for
from trunk_ros.data.quality import left_out
from trunk_ros.model import load_model, save_model
from trunk_ros.recording.importing.bag import read_bag
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.write import write_recording


def test_the_tip_of_an_arm_that_a_recorded_urdf_describes_can_be_diagnosed() -> None:
    bare = seen("six", {})
    there = replace(bare, description=(ARMS / "six.urdf").read_text())
    arm = gathered(*model_for(there, None))["stages"]["arm"]
    assert arm["possible"]
    assert "tool_offset" in arm["effects"]
    assert gathered(*model_for(bare, None))["stages"]["arm"]["missing"] == (
        "the model has neither link lengths nor a URDF"
    )


@pytest.mark.parametrize("text", ["", "\n", "\n1,2\n"])
def test_a_table_without_a_header_is_refused(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty.csv").write_text(text)
    assert main(["info", str(tmp_path / "empty.csv")]) == 2
    assert "empty.csv: is empty: a table begins with the names of its columns" in capsys.readouterr().err


def test_a_joint_under_two_names_is_named_by_both(tmp_path: Path) -> None:
    t = np.arange(0.0, 20.0, 0.01)
    angle = np.sin(np.outer(t, [1.0, 1.3]))
    recording = Recording.from_arrays(t, angle, angle, joints=["arm", "wrist"])
    (tmp_path / "own.yaml").write_text("/**: {ros__parameters: {arm: {joints: [arm, hand]}}}")
    told = gathered(*model_for(recording, str(tmp_path / "own.yaml")))
    said = (
        "wrist left out: the model has no such joint, and no topic has its hand: "
        "if these are the same, give them one name"
    )
    assert said in told["note"]
    assert said in left_out(recording, load_model(tmp_path / "own.yaml"))
    assert left_out(recording, load_model("direct")) == []


def test_a_mistyped_joint_is_said_in_one_line_by_all_commands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(0.0, 20.0, 0.01)
    angle = np.sin(np.outer(t, [1.0, 1.3]))
    read = angle + 1e-4 * np.random.default_rng(0).normal(size=angle.shape)
    recording = Recording.from_arrays(t, angle, read, joints=["shoulder", "forearm"])
    own = tmp_path / "own.yaml"
    own.write_text("/**: {ros__parameters: {arm: {joints: [shoulder, forarm]}}}")
    write_recording(tmp_path / "run", recording)
    said = (
        "forearm (the model's forarm?) left out: the model has no such joint, and no topic has its forarm: "
        "if these are the same, give them one name"
    )
    assert left_out(recording, load_model(own)) == [said]
    (names,) = gathered(recording, load_model(own))["mixed_up"]
    assert names.startswith("the model's joint 'forarm' is not in trunk/gearbox_states, which has 'forearm'")
    run, out = str(tmp_path / "run"), str(tmp_path / "out")
    assert main(["simulate", run, "--model", str(own), "--output", out]) == 0
    assert f"{run}: {said}\n" in capsys.readouterr().out
    assert main(["evaluate", run, "--model", str(own), "--json"]) == 0
    assert f"run: {said} ({own})\n" in capsys.readouterr().err
    gripper = Recording.from_arrays(t, angle, angle, joints=["shoulder", "gripper"])
    own.write_text("/**: {ros__parameters: {arm: {joints: [shoulder]}}}")
    assert left_out(gripper, load_model(own)) == ["gripper left out: the model has no such joint"]


def test_motors_of_other_names_are_no_strangers(tmp_path: Path) -> None:
    arm = replace(load_model("trunk").arm.only(("joint_1", "joint_2")), motors=("m1", "m2"))
    save_model(replace(load_model("trunk"), arm=arm), tmp_path / "own.yaml")
    t = np.arange(0.0, 20.0, 0.01)
    angle = np.sin(np.outer(t, [1.0, 1.3]))
    made = Recording.from_arrays(t, angle, 0.625 * angle, joints=["joint_1", "joint_2"])
    series = made.series | {"gearbox_states": replace(made.series["gearbox_states"], joints=("m1", "m2"))}
    told = gathered(*model_for(replace(made, series=series), str(tmp_path / "own.yaml")))
    assert told["stages"]["wire"]["possible"]
    assert told["note"] == []


def test_a_bag_of_foreign_topics_gets_a_mapping_that_takes_them_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "old"
    an_old_bag(bag, recorded(seconds=2.0))
    assert main(["diagnose", str(bag), "-o", str(tmp_path / "verdict")]) == 2
    assert f"`trunk_ros info {bag}` gives the mapping by which `trunk_ros import`" in capsys.readouterr().err
    assert main(["info", str(bag)]) == 0
    said = capsys.readouterr().out
    assert "/elbow_angle    std_msgs/msg/Float64" in said
    assert f"trunk_ros import {bag} --mapping MAP.yaml -o {bag}_arm" in said
    assert main(["info", str(bag), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["foreign_topics"]["/elbow_angle"] == "std_msgs/msg/Float64"
    (tmp_path / "map.yaml").write_text(said[said.index("  joints:") : said.index("then:")])
    assert read_bag(bag, tmp_path / "map.yaml").joints == ("joint_1",)


def test_topics_that_say_where_servos_are_to_go_are_setpoints_in_the_mapping_to_begin_with() -> None:
    kind = "sensor_msgs/msg/JointState"
    servo = foreign(Path("run.bag"), {"/arm/measured_js": kind, "/arm/setpoint_js": kind})
    assert '  setpoints: {position: {columns: ["/arm/setpoint_js.position[0]"], unit: rad}}' in servo
    assert '  gearbox_states: {position: {columns: ["/arm/measured_js.position[0]"], unit: rad}}' in servo
    assert not any("joint_states" in line for line in servo[3:])
    wire = foreign(Path("run.bag"), {"/camera": kind, "/motors": kind})
    assert [line.split(":")[0].strip() for line in wire[-3:-1]] == ["gearbox_states", "joint_states"]


def test_topics_that_were_renamed_beside_ours_get_a_mapping_as_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kind = "sensor_msgs/msg/JointState"
    ours = {"/cell/trunk/reference": kind, "/cell/trunk/controller_state/error": kind}
    wire = foreign(Path("run.bag"), ours | {"/cell/encoders": kind, "/cell/motor/state": kind})
    assert '  gearbox_states: {position: {columns: ["/cell/motor/state.position[0]"], unit: rad}}' in wire
    assert '  joint_states: {position: {columns: ["/cell/encoders.position[0]"], unit: rad}}' in wire
    bag = write_bag(tmp_path / "bag", motion("/trunk/reference") + motion("/motor/state"))
    assert main(["info", str(bag)]) == 0
    assert "/motor/state.position[0]" in capsys.readouterr().out
    assert main(["diagnose", str(bag), "-o", str(tmp_path / "verdict")]) == 2
    assert "gives the mapping" in capsys.readouterr().err
    tips = [
        ("/trunk/tip_pose", log, pose(log, (0.1, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0))) for _, log, _ in motion()
    ]
    seen = write_bag(tmp_path / "seen", motion("/encoders") + motion("/motor/state") + tips)
    assert main(["info", str(seen)]) == 0
    assert '  joint_states: {position: {columns: ["/encoders.position[0]"]' in capsys.readouterr().out
    half = write_bag(tmp_path / "half", motion("/joint_states") + motion("/motor/state"))
    assert main(["info", str(half)]) == 0
    assert "no trunk/gearbox_states, but /motor/state" in capsys.readouterr().out


def test_the_noise_of_a_slide_is_said_in_millimetres(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(0.0, 30.0, 0.01)
    went = 0.2 * np.sin(np.outer(t, [1.0]))
    read = went + np.random.default_rng(1).normal(0.0, 4e-4, went.shape)
    write_recording(tmp_path / "slide", Recording.from_arrays(t, went, read, joints=["slide"], unit="m"))
    assert main(["info", str(tmp_path / "slide")]) == 0
    (wire,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("  wire")]
    assert wire.endswith("mm")
    assert "rad" not in wire
    assert wire.count("mm") == 1  # of one joint there is one noise, and no range of it


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("%time,x\n1354825672489194938,1\n1354825672499194938,2\n", 'time: {column: "%time", unit: ns}'),
        ("stamp,x\n1354825672.48,1\n1354825672.49,2\n", "time: {column: stamp, unit: s}"),
        ("a: b,x\n0,1\n1,0\n", 'time: {column: "a: b", unit: s}'),
        ("x,t\n0,0\n1,1\n2,2\n", "time: {column: t, unit: s}"),
        ("uptime,x\n1200000000000,1\n1200010000000,2\n", "time: {column: uptime, unit: ns}"),
        ("torque,x\n3,1\n1,2\n2,1\n", "rate_hz: RATE"),
        ("  t    x\n  0    1\n  1    2\n", 'delimiter: " "'),
        ("t\t\tx\n0\t1\n1\t2\n", 'delimiter: " "'),
        ("t\tx\n0\t1\n1\t2\n", 'delimiter: "\\t"'),
        ("# arm, run 7\n# t x\n0 1\n1 2\n", "time: {column: t, unit: s}"),
    ],
)
def test_the_mapping_to_begin_with_has_the_time_that_a_table_has_as_yaml_takes_it(
    text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, mapping = tmp_path / "run.dat", tmp_path / "map.yaml"
    file.write_text(text)
    assert main(["info", str(file)]) == 0
    shown = capsys.readouterr().out
    assert f"  {said}" in shown
    proposed = shown[shown.index("save it as MAP.yaml:") + 20 : shown.index("then:")].replace("RATE ", "10 ")
    mapping.write_text(proposed.replace("MOTOR_SIDE_ANGLE", "x").replace("JOINT_ANGLE", "x"))
    assert len(read_csv(file, mapping).require("joint_states").stamp) > 1


def test_the_columns_of_a_table_for_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.csv").write_text("t_ms,enc\n0,1.5\n10,1.6\n20,1.7\n")
    assert main(["info", str(tmp_path / "run.csv"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows"] == 3
    assert told["columns"] == {"t_ms": "0", "enc": "1.5"}
    assert told["time"] == {"column": "t_ms", "unit": "ms"}


def test_a_table_of_numbers_apart_by_blanks_has_no_header(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.savetxt(tmp_path / "run.txt", np.random.default_rng(0).normal(size=(20, 3)), fmt="%16.7e")
    assert main(["info", str(tmp_path / "run.txt")]) == 2
    assert "line 1 holds numbers: a table begins with the names" in capsys.readouterr().err


def test_a_mapping_that_is_no_yaml_is_told_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "map.yaml").write_text("time: {column: %time, unit: ns}\n")
    assert main(["check", str(tmp_path / "map.yaml")]) == 2
    said = capsys.readouterr().err
    assert "is not YAML in line 1, column 16 (found character that cannot start any token)" in said
