"""The nodes run an arm by its URDF whose motors move several joints."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.nodes.graph import bag_messages, needs_ros, trunk
from trunk_ros.chain import Chain
from trunk_ros.model import load_model
from trunk_ros.recording.read import read_recording

URDF = Path(__file__).parents[1] / "concealed" / "arms" / "three.urdf"
MODEL = """/**:
  ros__parameters:
    arm: {{urdf: {urdf}, payload: 0.05}}
    wire: {{coupling: [0.6, 0, 0, 0.1, 0.5, 0, 0, 0.2, -0.5], motors: [m1, m2, m3], dead_band: [0.002]}}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "my-arm.yaml"
    path.write_text(MODEL.format(urdf=URDF))
    return path


@needs_ros
def test_the_compensator_solves_the_matrix_and_remembers_each_wires_direction(file: Path) -> None:
    from trunk_ros.nodes.control.compensation import Compensation

    model = load_model(file)
    stamp = np.arange(600) * 0.01
    wanted = model.arm.rest + 0.3 * (1 - np.cos(stamp))[:, None] * [1.0, 0.7, 0.8]
    compensation = Compensation(model, 1e-5, model.arm.asked(wanted[0]))
    motors = np.array([compensation.step(reference, 0.01) for reference in wanted])
    theta, _ = Chain(model, "wire").run(motors, stamp)
    late = stamp > 1.0
    assert theta[late] == pytest.approx(wanted[late], abs=3e-4)
    careless, _ = Chain(model, "wire").run(model.arm.asked(wanted), stamp)
    assert np.abs(careless - wanted)[late].max() > 1.5e-3


@needs_ros
def test_each_motor_is_led_by_its_own_servo(file: Path) -> None:
    from trunk_ros.nodes.control.compensation import Compensation

    slow = {"servo_bandwidth": {"relative": np.array([-0.5, 0.0, 0.3])}}
    model = replace(load_model(file), effects=slow)
    stamp, size = np.arange(600) * 0.01, np.array([0.3, 0.21, 0.24])
    compensation = Compensation(model, 1e-5, model.arm.asked(model.arm.rest))
    motors = []
    for now in stamp:
        t = 2.0 * (now + compensation.sight)
        angle, motion = 1 - np.cos(t), (2.0 * np.sin(t) * size, 4.0 * np.cos(t) * size)
        motors.append(compensation.step(model.arm.rest + angle * size, 0.01, *motion))
    phi, _ = Chain(model, "servo").run(np.array(motors), stamp)
    theta, _ = Chain(model, "wire").run(phi, stamp)
    off = theta - model.arm.rest - (1 - np.cos(2.0 * stamp))[:, None] * size
    assert np.sqrt(np.mean(off[stamp > 1.0] ** 2, axis=0)).max() < 3e-4


@needs_ros
def test_a_motor_may_not_move_any_joint_outside_its_limits(file: Path) -> None:
    from trunk_ros.nodes.bus import gearbox_limits, within

    arm = load_model(file).arm
    lower, upper = gearbox_limits(arm)
    corners = np.array(np.meshgrid(*zip(lower, upper, strict=True))).reshape(3, -1).T
    outside = [arm.driven(corner) for corner in corners]
    assert all(((joint < arm.lower) | (joint > arm.upper)).any() for joint in outside)
    for corner in corners:
        kept = arm.driven(within(corner, arm))
        assert (kept >= arm.lower - 0.0021).all()
        assert (kept <= arm.upper + 0.0021).all()
    inside = arm.asked(arm.rest)
    assert within(inside, arm) == pytest.approx(inside)


@needs_ros
def test_motors_hold_the_weight_of_all_joints_that_they_move(file: Path) -> None:
    """Their power is what the weight takes."""
    from trunk_ros.nodes.bus import SimulatedBus

    arm = load_model(file).arm
    sample = SimulatedBus(load_model(file)).read(0.0)
    step = 1e-6 * np.array([1.0, -2.0, 0.5])
    work = -arm.load(arm.driven(sample.position)[None])[0] @ arm.driven(step)
    assert sample.effort @ step == pytest.approx(work, rel=1e-3)


@needs_ros
def test_bringup_runs_an_arm_by_its_urdf(file: Path, tmp_path: Path) -> None:
    bag = tmp_path / "run"
    done = trunk("bringup", "--output", bag, "--seconds", 8, "--sim-time", "--model", file)
    assert done.returncode == 0, done.stderr
    recording, model = read_recording(bag), load_model(file)
    assert recording.description == URDF.read_text()
    assert recording.series["gearbox_states"].joints == ("m1", "m2", "m3")
    assert recording.series["joint_states"].joints == model.arm.joints
    joints, tip = recording.series["joint_states"], recording.tip
    assert tip is not None
    assert np.ptp(joints.position, axis=0).min() > 0.05
    expected = model.arm.tip(joints.position)
    assert tip.position == pytest.approx(expected[:, :3], abs=1e-9)
    assert tip.frame == "base_link"
    assert len(bag_messages(bag)["/trunk/tip_pose"]) == len(joints.stamp)
