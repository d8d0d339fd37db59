"""What URDF and SDF can say, and what is left."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from test.export.arms import SDF, URDF, model_of, pair
from trunk_ros.arm.urdf import joint_limits
from trunk_ros.errors import TrunkError
from trunk_ros.export.run import export

STOP = {"hard_stop": {"upper": pair(1.0, 100.0), "form": "upper"}}


def test_urdf_says_limits_lengths_tilt_and_reductions(tmp_path: Path) -> None:
    effects = {
        **STOP,
        "velocity_saturation": {"v_max": 1.2},
        "ratio_error": {"relative": pair(0.02, 0.02)},
        "link_length_error": {"length_error": pair(0.003, 0.0)},
        "base_tilt": {"angle": 0.05},
        "backlash": {"half_width": pair(1e-3, 0.0)},
    }
    (tmp_path / "arm.urdf").write_text(URDF)
    sheet = export(model_of(effects), "urdf", tmp_path / "arm.urdf")
    root = ElementTree.fromstring(sheet.text)
    shoulder, elbow = root.findall("joint")
    assert joint_limits(sheet.text) == {"shoulder": (-2.0, 1.0), "elbow": (-2.0, 2.0)}
    assert [float(j.find("limit").get("velocity")) for j in (shoulder, elbow)] == [1.2, 1.2]
    assert shoulder.find("origin").get("rpy").split()[0] == "0.05"
    assert elbow.find("origin").get("xyz") == "0 0 0.203"
    assert float(root.find("*/actuator/mechanicalReduction").text) == pytest.approx(50 / 1.02)
    assert sheet.layer.effects["ratio_error"]["relative"] == pytest.approx([0.02, 0.0])
    assert sheet.layer.effects["backlash"]["half_width"] == pytest.approx([1e-3, 0.0])
    assert "<!-- mine -->" in sheet.text
    assert "<!-- trunk_ros: hard_stop at 1 rad: limit -->" in sheet.text


def test_top_speeds_of_two_ways_stay_together_in_the_layer(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    effects = {"velocity_saturation": {"v_max": 1.2}, "uneven_speed": {"excess": pair(0.2, 0.0)}}
    sheet = export(model_of(effects), "urdf", tmp_path / "arm.urdf")
    assert set(sheet.layer.effects) == set(effects)
    assert not sheet.lines


def test_sdf_says_play_and_lag_beside_a_position_controller(tmp_path: Path) -> None:
    effects = {
        **STOP,
        "backlash": {"half_width": pair(1e-3, 4e-3)},
        "viscous_lag": {"time_constant": pair(0.0, 0.02)},
        "load_elasticity": {"compliance": pair(0.0, 0.02)},
        "base_tilt": {"angle": 0.05},
    }
    (tmp_path / "arm.sdf").write_text(SDF)
    sheet = export(model_of(effects), "sdf", tmp_path / "arm.sdf")
    root = ElementTree.fromstring(sheet.text)
    shoulder, elbow = root.iter("joint")
    softer = 50 / (1 + 50 * 0.02)
    assert float(elbow.find("axis/dynamics/friction").text) == pytest.approx(4e-3 * softer)
    assert float(root.find("model/plugin/p_gain").text) == pytest.approx(softer)
    assert float(elbow.find("axis/dynamics/damping").text) == pytest.approx(0.1 + 0.02 * softer)
    assert float(shoulder.find("axis/limit/upper").text) == 1.0
    assert root.find("model/pose").text.split()[3] == "0.05"
    assert sheet.layer.effects == {"backlash": {"half_width": pytest.approx(pair(1e-3))}}


def test_sdf_leaves_a_lag_that_is_no_damping(tmp_path: Path) -> None:
    (tmp_path / "arm.sdf").write_text(SDF)
    effects = {"viscous_lag": {"time_constant": pair(0.0, 0.02), "form": "shift"}}
    sheet = export(model_of(effects), "sdf", tmp_path / "arm.sdf")
    assert (sheet.lines, set(sheet.layer.effects)) == ([], {"viscous_lag"})


@pytest.mark.parametrize(("to", "text"), [("urdf", "<robot"), ("urdf", SDF), ("sdf", URDF)])
def test_other_files_are_refused(to: str, text: str, tmp_path: Path) -> None:
    (tmp_path / "arm").write_text(text)
    with pytest.raises(TrunkError, match=r"arm(:| is) no (XML|URDF|SDF)"):
        export(model_of({}), to, tmp_path / "arm")


def test_a_joint_that_is_not_there_is_said(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF.replace('name="elbow" type', 'name="knee" type'))
    sheet = export(model_of({"hard_stop": {"upper": pair(1.0, 1.0)}}), "urdf", tmp_path / "arm.urdf")
    assert "elbow: not in the file" in sheet.remarks
    assert np.array_equal(sheet.layer.effects["hard_stop"]["upper"] < 100.0, [False, True])
