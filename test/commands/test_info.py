"""``info``: what it says of recordings that need something before they can be diagnosed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from test.diagnosis.test_tip_in_space import ARMS, seen
from trunk_ros.commands.info import gathered, model_for
from trunk_ros.diagnosis.data.quality import left_out
from trunk_ros.model import load_model, save_model
from trunk_ros.recording.recording import Recording


def test_the_tip_of_an_arm_that_a_recorded_urdf_describes_can_be_diagnosed() -> None:
    bare = seen("six", {})
    there = replace(bare, description=(ARMS / "six.urdf").read_text())
    arm = gathered(*model_for(there, None))["stages"]["arm"]
    assert arm["possible"]
    assert "tool_offset" in arm["effects"]
    assert gathered(*model_for(bare, None))["stages"]["arm"]["missing"] == (
        "the model has neither link lengths nor a URDF"
    )


def test_a_joint_under_two_names_is_named_by_both(tmp_path: Path) -> None:
    t = np.arange(0.0, 20.0, 0.01)
    angle = np.sin(np.outer(t, [1.0, 1.3]))
    recording = Recording.from_arrays(t, angle, angle, joints=["arm", "wrist"])
    (tmp_path / "own.yaml").write_text("/**: {ros__parameters: {arm: {joints: [arm, hand]}}}")
    told = gathered(*model_for(recording, str(tmp_path / "own.yaml")))
    said = "the model's hand is in no topic, which have wrist: if these are the same, give them one name"
    assert said in told["note"]
    assert said in left_out(recording, load_model(tmp_path / "own.yaml"))
    assert left_out(recording, load_model("direct")) == []


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
