"""Poses of the tip that are mixed up are told as such, and links that are a little others are none."""

from __future__ import annotations

from dataclasses import replace

import pytest
from scipy.spatial.transform import Rotation

from test.diagnosis.arms import diagnose, recorded
from trunk_ros.data.mix_ups import mix_ups, without_mix_ups
from trunk_ros.diagnosis.report.page import render
from trunk_ros.model import load_model
from trunk_ros.recording.recording import PoseSeries, Recording

TRUNK = load_model("trunk")


@pytest.fixture(scope="module")
def good() -> Recording:
    return recorded({}, 30.0)


def _with_tip(recording: Recording, turn: Rotation, size: float, order: list[int]) -> Recording:
    """With poses of the tip, in a base that is turned, of that unit and order."""
    shown = recording.series["joint_states"]
    poses = TRUNK.arm.tip(shown.position)
    orientation = (turn * Rotation.from_quat(poses[:, 3:])).as_quat()[:, order]
    return replace(recording, tip=PoseSeries(shown.stamp, size * turn.apply(poses[:, :3]) + 0.1, orientation))


IN_PLACE, AS_TOLD = Rotation.identity(), [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("turn", "size", "order", "words"),
    [
        (IN_PLACE, 1e3, AS_TOLD, "looks like mm"),
        (Rotation.from_euler("z", 90, degrees=True), 1.0, AS_TOLD, "by 0, 0, 90 degrees"),
        (IN_PLACE, 1.0, [3, 0, 1, 2], "look like w, x, y, z"),
    ],
)
def test_poses_of_another_unit_frame_or_order_are_told_and_left_out(
    good: Recording, turn: Rotation, size: float, order: list[int], words: str
) -> None:
    made = _with_tip(good, turn, size, order)
    (found,) = mix_ups(made, TRUNK)
    assert (found.stage, found.joints, found.certain) == ("arm", good.joints, True)
    assert words in found.statement
    assert without_mix_ups(made, [found]).tip is None
    assert without_mix_ups(made, [found]).series.keys() == good.series.keys()


@pytest.mark.parametrize("turned", [0.0, 10.0, 30.0])
def test_a_base_that_is_a_little_turned_is_no_mix_up(good: Recording, turned: float) -> None:
    made = _with_tip(good, Rotation.from_euler("xz", [turned, turned], degrees=True), 1.03, AS_TOLD)
    assert mix_ups(made, TRUNK) == []


def test_poses_that_are_mixed_up_are_not_explained_and_the_joints_are_judged(good: Recording) -> None:
    result = diagnose(_with_tip(good, IN_PLACE, 1e3, AS_TOLD))
    assert (result.verdict, result.findings) == ("unexplained", [])
    assert [(one.stage, one.joints) for one in result.unexplained] == [("arm", list(good.joints))]
    assert result.stages["wire"]["compared"]
    assert "looks like mm" in render(result)
