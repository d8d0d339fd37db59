"""The programs for MuJoCo of docs/simulators.md run as they stand."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from test.export.arms import JOINTS, MJCF, SERVOS, model_of, pair
from trunk_ros.model import save_model
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording

pytest.importorskip("mujoco")
ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "simulators.md").read_text(encoding="utf-8")


def programs_of_the_page(folder: Path) -> None:
    for name, text in re.findall(r"```python\n# (\w+_\w+\.py):(.*?)```", PAGE, re.DOTALL):
        (folder / name).write_text(f"#{text}")


def test_the_motor_side_of_a_geared_simulation_is_a_gear_apart_from_the_joint(tmp_path: Path) -> None:
    programs_of_the_page(tmp_path)
    stamp = np.arange(0.0, 3.0, 0.01)
    asked = JointSeries(stamp, JOINTS, 0.4 + 0.3 * np.sin(stamp)[:, None] * [1.0, -1.0])
    write_recording(tmp_path / "run", Recording("run", 10**18, 3.0, {"setpoints": asked}))
    gear = SERVOS.replace("<position", '<position gear="2"')
    (tmp_path / "arm.xml").write_text(MJCF.format(drives=gear))
    for program in ("record_mujoco.py", "play_exported.py"):
        words = [sys.executable, program, "run", "arm.xml", program[:4]]
        subprocess.run(words, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True)
        shown = read_recording(tmp_path / program[:4]).require("joint_states").position
        assert np.abs(2.0 * shown - asked.position).max() < 0.05, "it begins and stays where it is sent"
    motor, joint = (
        read_recording(tmp_path / "reco").require(f"{side}_states") for side in ("gearbox", "joint")
    )
    np.testing.assert_allclose(motor.position, 2.0 * joint.position, atol=1e-12)


def test_the_programs_of_the_page_run(tmp_path: Path) -> None:
    programs_of_the_page(tmp_path)
    stamp = np.arange(0.0, 3.0, 0.01)
    asked = JointSeries(stamp, JOINTS, 0.3 * np.sin(stamp)[:, None] * [1.0, -1.0])
    write_recording(tmp_path / "run", Recording("run", 10**18, 3.0, {"setpoints": asked}))
    (tmp_path / "arm.xml").write_text(MJCF.format(drives=SERVOS))
    save_model(model_of({"backlash": {"half_width": pair(0.0, 0.05)}}), tmp_path / "arm.reality.yaml")
    for program in ("record_mujoco.py", "play_exported.py"):
        words = [sys.executable, program, "run", "arm.xml", program[:4]]
        subprocess.run(words, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, check=True)
    plain, played = (read_recording(tmp_path / name).require("joint_states") for name in ("reco", "play"))
    motor = read_recording(tmp_path / "reco").require("gearbox_states")
    np.testing.assert_array_equal(motor.position, plain.position)  # these actuators have no gear
    apart = np.abs(plain.position - played.position)
    assert apart[:, 0].max() < 0.02
    assert apart[100:, 1].max() > 0.04
