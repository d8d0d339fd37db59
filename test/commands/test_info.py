"""``info``: what it says of recordings that need something before they can be diagnosed."""

from __future__ import annotations

from dataclasses import replace

from test.diagnosis.test_tip_in_space import ARMS, seen
from trunk_ros.commands.info import gathered, model_for


def test_the_tip_of_an_arm_that_a_recorded_urdf_describes_can_be_diagnosed() -> None:
    bare = seen("six", {})
    there = replace(bare, description=(ARMS / "six.urdf").read_text())
    arm = gathered(*model_for(there, None))["stages"]["arm"]
    assert arm["possible"]
    assert "tool_offset" in arm["effects"]
    assert gathered(*model_for(bare, None))["stages"]["arm"]["missing"] == (
        "the model has neither link lengths nor a URDF"
    )
