"""Commands on the page can be pasted: they have the arguments of the diagnosis, and the files are there."""

import html
import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.diagnosis import made
from test.diagnosis.arms import of_the_wires, on, recorded
from test.diagnosis.made import page_of
from trunk_ros.__main__ import main
from trunk_ros.commands.diagnose import parser
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.model import Model, load_model
from trunk_ros.nodes.run.arguments import parser as bringup
from trunk_ros.nodes.run.plan import split_ros
from trunk_ros.recording.namespace import choose
from trunk_ros.recording.topics import TOPICS, expected_type
from trunk_ros.recording.write import write_recording
from trunk_ros.trajectory import Trajectory

MOTION = {"separates": ["backlash", "tension_error"], "statement": "x", "trajectory": "experiment_wire.yaml"}


def commands(page: str) -> list[list[str]]:
    """The words of every command that is printed to be pasted."""
    found = re.findall(r"<pre><code>(.*?)</code></pre>", page, re.S)
    text = html.unescape("\n".join(found)).replace("\\\n", " ")
    return [shlex.split(line) for line in text.splitlines()]


def told(**provenance: Any) -> Diagnosis:
    return several([130.0], **provenance)


def several(seconds: list[float], **provenance: Any) -> Diagnosis:
    """With a motion for each of these lengths, and one of them twice."""
    files = ["experiment_wire.yaml", "experiment_servo.yaml"][: len(seconds)]
    asked = [MOTION | {"trajectory": file} for file in files]
    motions = {
        file: Trajectory(("joint_1",), np.array([0.0, end]), np.zeros((2, 1)))
        for file, end in zip(files, seconds, strict=True)
    }
    result = replace(made.backlash(), experiments=[*asked, asked[0]], trajectories=motions)
    result.provenance |= provenance
    return result


def of(page: str, name: str) -> list[str]:
    return all_of(page, name)[0]


def all_of(page: str, name: str) -> list[list[str]]:
    return [words[2:] for words in commands(page) if words[1] == name]


def test_the_commands_after_a_motion_have_the_arguments_of_the_first_diagnosis() -> None:
    given = {"model": "my arm.yaml", "until": "5", "namespace": "/left", "output": "out"}
    page = page_of(told(model="my arm.yaml", bags=["a b"], arguments=given))
    again = parser().parse_args(of(page, "diagnose"))
    assert (again.bag, again.model, again.until) == (["a b", "decisive"], "my arm.yaml", "5")
    assert (again.namespace, again.output) == ("/left", "settled")
    own, ros = split_ros(of(page, "bringup"))
    played = bringup().parse_args(own)
    assert (played.model, played.trajectory, played.seconds) == (
        "my arm.yaml",
        "out/experiment_wire.yaml",
        131,
    )
    assert ros == ["--ros-args", "-r", "__ns:=/left"]
    assert of(page, "evaluate") == ["another_run", "-m", "out/model.yaml", "--namespace", "/left"]
    assert of(page, "compensator") == ["--ros-args", "--params-file", "out/model.yaml", "-r", "__ns:=/left"]
    assert "--until 5 holds for the new recording as well" in page


@pytest.mark.parametrize("given", [{"urdf": "arm.urdf"}, {}])
def test_after_a_urdf_the_motion_is_played_with_its_arm_without_effects(
    given: dict[str, str], tmp_path: Path
) -> None:
    result = told(model=given.get("urdf", "robot_description"), arguments=given)
    page = page_of(result)
    again = parser().parse_args(of(page, "diagnose"))
    assert (again.model, again.urdf) == (None, given.get("urdf"))
    assert bringup().parse_args(of(page, "bringup")).model == "nominal.yaml"
    result.save(tmp_path)
    found, played = (load_model(tmp_path / name) for name in ("model.yaml", "nominal.yaml"))
    assert found.effects
    assert not played.effects
    assert Model(found.arm).hash() == played.hash()


def test_where_the_nominal_arm_is_in_a_file_it_is_not_written_again(tmp_path: Path) -> None:
    told(model="my-arm.yaml", arguments={"model": "my-arm.yaml"}).save(tmp_path)
    assert not (tmp_path / "nominal.yaml").exists()


def test_the_nominal_arm_needs_no_model() -> None:
    page = page_of(told(model="trunk", arguments={"output": "v"}))
    assert "-m" not in of(page, "bringup") + of(page, "diagnose")
    assert "__ns" not in page
    assert "holds for the new recording" not in page


def test_a_simulator_is_compared_on_the_new_motion_alone() -> None:
    given = {"against": "sim1", "model": "my-arm.yaml", "from_time": "5", "namespace": "/left"}
    page = page_of(told(model="my-arm.yaml", bags=["run1"], arguments=given))
    again = parser().parse_args(of(page, "diagnose"))
    assert (again.bag, again.against, again.output) == (["decisive"], "decisive_simulated", "settled")
    assert (again.model, again.namespace, again.from_time) == ("my-arm.yaml", "/left", None)
    assert "let your simulator run the same motion" in page
    assert "hold" not in page[page.index('id="settle"') : page.index('id="data"')].split("</pre>")[1]
    both = page_of(several([130.0, 40.0], arguments=given))
    *apart, _ = map(parser().parse_args, all_of(both, "diagnose"))  # the last one reproduces the page
    assert [(each.bag, each.against, each.output) for each in apart] == [
        (["decisive_1"], "decisive_1_simulated", "settled_1"),
        (["decisive_2"], "decisive_2_simulated", "settled_2"),
    ]


def test_several_motions_are_recorded_apart_and_diagnosed_at_once() -> None:
    page = page_of(several([130.0, 40.5], bags=["run1"], arguments={}))
    played = [bringup().parse_args(words) for words in all_of(page, "bringup")]
    assert [(one.trajectory, one.output, one.seconds) for one in played] == [
        ("experiment_wire.yaml", "decisive_1", 131),
        ("experiment_servo.yaml", "decisive_2", 42),
    ]
    together, _ = all_of(page, "diagnose")  # the other one reproduces the page
    assert together == ["run1", "decisive_1", "decisive_2", "-o", "settled"]


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ({"from_time": "200"}, []),
        ({"from_time": "100"}, []),  # the other motion is shorter
        ({"from_time": "70%", "until": "20"}, ["--until", "20"]),
        ({"from_time": "10", "until": "300"}, ["--from-time", "10", "--until", "300"]),
        ({"from_time": "90%"}, ["--from-time", "90%"]),
    ],
)
def test_a_cut_that_leaves_nothing_of_a_motion_is_left_out(given: dict[str, str], kept: list[str]) -> None:
    page = page_of(several([130.0, 40.0], bags=["run1"], arguments=given))
    assert of(page, "diagnose")[3:-2] == kept
    said = "--from-time {from_time} is left out: a motion is shorter than that".format(**given)
    assert (said in page) == ("--from-time" not in kept)


def test_a_played_motion_is_read_with_the_namespace_of_the_diagnosis() -> None:
    """What a recorder in a namespace records: that, the clock and tf."""
    given = {"namespace": "left/"}
    page = page_of(told(model="trunk", arguments=given))
    space = split_ros(of(page, "bringup"))[1][-1].removeprefix("__ns:=")
    recorded = {f"{space}/{TOPICS[key]}": expected_type(key) for key in ("setpoints", "gearbox_states")}
    recorded |= {f"{space}/joint_states": expected_type("joint_states"), "/clock": "rosgraph_msgs/msg/Clock"}
    asked = parser().parse_args(of(page, "diagnose")).namespace
    chosen, remarks = choose("decisive", recorded, asked)
    assert {*chosen} >= {"setpoints", "gearbox_states", "joint_states"}
    assert not remarks


def test_durations_are_plain_numbers() -> None:
    result = told()
    name = next(iter(result.quality))
    result.quality[name] |= {"duration": 12345.6, "from": 0.0, "until": 10000.0}
    assert "0 to 10000 s of 12345.6 s" in page_of(result)


def test_diagnose_hands_on_what_it_was_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_recording(
        tmp_path / "run1", of_the_wires(recorded({"backlash": {"half_width": on(2, 8e-4)}}, 10.0))
    )
    assert main(["diagnose", "run1", "-m", "trunk", "--until", "90%", "-o", "v"]) == 0
    page = (tmp_path / "v" / "report.html").read_text()
    assert (tmp_path / of(page, "evaluate")[-1]).is_file()
    assert all("90%" in words for words in commands(page) if words[1] == "diagnose")
    assert page.count("run1, 0 to 8.99 s of 9.99 s") == 2
