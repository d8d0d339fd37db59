"""Friction, armature and the last link, written into a simulator's file, are read back from it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from test.bodies.arms import (
    ARMATURE,
    DAMPING,
    FRICTION,
    HIDDEN_CENTRE,
    HIDDEN_MASS,
    JOINTS,
    MASS,
    model_of,
    truth,
    urdf,
)
from test.export.arms import SDF
from test.export.arms import model_of as pair_of
from trunk_ros.__main__ import main
from trunk_ros.bodies.found import Bodies, Centre, Value, save_bodies
from trunk_ros.errors import ModelError
from trunk_ros.export.run import export
from trunk_ros.export.sheet import Sheet
from trunk_ros.model import Model, save_model

mujoco = pytest.importorskip("mujoco")

BODIES = Bodies(
    ("run",),
    {
        joint: {
            "friction": Value(float(FRICTION[k]), 0.01, "N m"),
            "damping": Value(float(DAMPING[k]), 0.01, "N m s/rad"),
            "armature": Value(float(ARMATURE[k]), 0.01, "kg m^2"),
            "offset": Value(0.1, 0.01, "N m"),
        }
        for k, joint in enumerate(JOINTS)
    },
    JOINTS[-1],
    Value(HIDDEN_MASS, 0.01, "kg"),
    Centre(HIDDEN_CENTRE, (1e-3, 1e-3, None), HIDDEN_MASS),
)
SERVO = {"kp": 100.0, "kv": 4.0}


def file_of(change: Any = None, drives: bool = True) -> str:
    """The arm as its model has it, in MJCF, with position actuators."""
    spec = mujoco.MjSpec.from_string(urdf())
    for name in JOINTS if drives else ():
        drive = spec.add_actuator(name=f"{name}_drive", target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.set_to_position(**SERVO)
    spec.body("link_2").add_site(name="tip", pos=[0, 0, 0.25])
    if change is not None:
        change(spec)
    spec.compile()
    return str(spec.to_xml())


def written(tmp_path: Path, text: str, model: Model | None = None, bodies: Bodies = BODIES) -> Sheet:
    (tmp_path / "arm.xml").write_text(text)
    return export(model or Model(model_of().arm), "mjcf", tmp_path / "arm.xml", None, bodies)


def whole(model: Any) -> tuple[float, np.ndarray]:
    """Mass of all that is fixed to the last link, and its centre in the world, the arm being bent."""
    data = mujoco.MjData(model)
    for name, angle in zip(JOINTS, (0.3, 0.5, -0.8), strict=True):
        data.joint(name).qpos[0] = angle
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    last = int(model.joint(JOINTS[-1]).bodyid[0])
    return float(model.body_subtreemass[last]), data.subtree_com[last].copy()


def test_mujoco_reads_what_was_found(tmp_path: Path) -> None:
    sheet = written(tmp_path, file_of())
    model = mujoco.MjModel.from_xml_string(sheet.text)
    places = [model.joint(name).dofadr[0] for name in JOINTS]
    assert model.dof_armature[places] == pytest.approx(ARMATURE)
    assert model.dof_damping[places] == pytest.approx(DAMPING)
    assert model.dof_frictionloss[places] == pytest.approx(FRICTION)
    assert model.body("link_2").mass[0] == pytest.approx(HIDDEN_MASS)
    assert model.body("link_2").ipos == pytest.approx(HIDDEN_CENTRE)
    assert model.body("link_1").mass[0] == pytest.approx(MASS[1])
    assert "<!-- trunk_ros: bodies: armature 0.15 kg m^2: armature -->" in sheet.text
    assert "<!-- trunk_ros: bodies: mass 1.1 kg, centre 0.02, -0.015, 0.14 m from elbow -->" in sheet.text
    assert "waist: its friction lets it stand up to 0.006 rad off its actuator's command" in sheet.remarks


def test_a_file_with_other_frames_and_a_tool_of_its_own_gets_the_same_link(tmp_path: Path) -> None:
    def change(spec: Any) -> None:
        spec.compiler.fusestatic = False
        link = spec.body("link_2")
        tool = link.add_body(name="gripper", pos=[0, 0.01, 0.2])
        tool.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0], mass=0.2)
        half = np.sqrt(0.5)  # a quarter turn about Z of the link's own frame
        link.quat = [half, 0, 0, half]
        spec.joint(JOINTS[-1]).axis = [0, -1, 0]
        link.sites[0].pos = [0, 0, 0.25]

    model = mujoco.MjModel.from_xml_string(written(tmp_path, file_of(change)).text)
    true_mass, true_centre = whole(truth())
    mass, centre = whole(model)
    assert mass == pytest.approx(true_mass)
    assert centre == pytest.approx(true_centre, abs=1e-6)
    assert model.body("gripper").mass[0] == pytest.approx(0.2)


def test_a_frame_that_is_another_arms_is_left_alone(tmp_path: Path) -> None:
    def change(spec: Any) -> None:
        spec.joint("waist").axis = [0, 1, 0]

    sheet = written(tmp_path, file_of(change))
    assert mujoco.MjModel.from_xml_string(sheet.text).body("link_2").mass[0] == pytest.approx(MASS[2])
    assert any("its frame in the file cannot be found" in remark for remark in sheet.remarks)


def test_a_centre_without_a_mass_keeps_the_moment_that_was_seen(tmp_path: Path) -> None:
    sheet = written(tmp_path, file_of(), None, replace(BODIES, mass=None))
    model = mujoco.MjModel.from_xml_string(sheet.text)
    mass = float(model.body("link_2").mass[0])
    assert mass == pytest.approx(MASS[2])
    assert mass * model.body("link_2").ipos == pytest.approx(HIDDEN_MASS * np.array(HIDDEN_CENTRE))


def test_friction_is_not_written_where_backlash_and_lag_are(tmp_path: Path) -> None:
    effects = {
        "backlash": {"half_width": np.array([0.0, 4e-3, 0.0])},
        "viscous_lag": {"time_constant": np.array([0.0, 0.0, 0.02])},
    }
    sheet = written(tmp_path, file_of(), Model(model_of().arm, effects))
    model = mujoco.MjModel.from_xml_string(sheet.text)
    assert model.joint("shoulder").frictionloss[0] == pytest.approx(4e-3 * SERVO["kp"])
    assert model.joint("elbow").damping[0] == pytest.approx(0.02 * SERVO["kp"])
    assert model.joint("elbow").frictionloss[0] == pytest.approx(FRICTION[2])
    assert any(
        remark.startswith("shoulder: friction 0.8 N m: not written, backlash") for remark in sheet.remarks
    )
    assert any(remark.startswith("elbow: damping 0.2 N m s/rad: not written") for remark in sheet.remarks)


def test_what_friction_and_masses_do_to_motors_is_written_once(tmp_path: Path) -> None:
    of_motors = {"load_droop": {"gain": 0.01}, "motor_friction": {"friction": 2e-3}}
    model = Model(model_of().arm, {**of_motors, "servo_delay": {"delay": 0.02}})
    sheet = written(tmp_path, file_of(), model)
    for name in of_motors:
        assert any(remark.startswith(f"{name}: left out") for remark in sheet.remarks)
        assert name not in sheet.layer.effects
    assert "servo_delay" in str([*sheet.lines, *sheet.left])
    alone = written(tmp_path, file_of(), model, Bodies(("run",), {}, JOINTS[-1], None, None))
    assert "load_droop" in str([*alone.lines, *alone.left])


def test_urdf_has_friction_damping_and_the_link(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf())
    sheet = export(Model(model_of().arm), "urdf", tmp_path / "arm.urdf", None, BODIES)
    root = ElementTree.fromstring(sheet.text)
    said = [joint.find("dynamics").attrib for joint in root.findall("joint")[:3]]
    assert [float(each["friction"]) for each in said] == pytest.approx(FRICTION)
    assert [float(each["damping"]) for each in said] == pytest.approx(DAMPING)
    inertial = root.find("link[@name='link_2']/inertial")
    assert float(inertial.find("mass").get("value")) == pytest.approx(HIDDEN_MASS)
    assert [float(x) for x in inertial.find("origin").get("xyz").split()] == pytest.approx(HIDDEN_CENTRE)
    assert "elbow: armature 0.06 kg m^2: this file has no place for it" in sheet.remarks
    model = mujoco.MjModel.from_xml_string(sheet.text)
    assert whole(model)[1] == pytest.approx(whole(truth())[1], abs=1e-6)


def test_sdf_has_friction_and_damping_and_names_the_link(tmp_path: Path) -> None:
    (tmp_path / "arm.sdf").write_text(SDF)
    pair = replace(
        BODIES,
        joints={"shoulder": BODIES.joints["shoulder"], "elbow": BODIES.joints["elbow"]},
    )
    effects = {"backlash": {"half_width": np.array([0.0, 4e-3])}}
    sheet = export(pair_of(effects), "sdf", tmp_path / "arm.sdf", None, pair)
    shoulder, elbow = ElementTree.fromstring(sheet.text).iter("joint")
    assert float(shoulder.find("axis/dynamics/friction").text) == FRICTION[1]
    assert float(shoulder.find("axis/dynamics/damping").text) == DAMPING[1]
    assert float(elbow.find("axis/dynamics/friction").text) == pytest.approx(4e-3 * 50)
    assert any("mass 1.1 kg" in remark for remark in sheet.remarks)


def test_the_command_finds_them_beside_the_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(urdf())
    save_model(Model(model_of().arm), "model.yaml")
    save_bodies(BODIES, Path("bodies.yaml"))
    words = ["export", "model.yaml", "--to", "urdf", "--into", "arm.urdf"]
    assert main([*words, "-o", "new.urdf"]) == 0
    assert "friction, armature and last link from bodies.yaml" in capsys.readouterr().out
    assert 'friction="0.6"' in Path("new.urdf").read_text()
    Path("bodies.yaml").rename("others.yaml")
    assert main([*words, "-o", "plain.urdf"]) == 0
    assert "friction=" not in Path("plain.urdf").read_text()
    assert main([*words, "-o", "named.urdf", "--bodies", "others.yaml"]) == 0
    assert 'friction="0.6"' in Path("named.urdf").read_text()
    assert main([*words, "-o", "wrong.urdf", "--bodies", "model.yaml"]) == 2
    assert "model.yaml is no trunk_ros/bodies/1" in capsys.readouterr().err


def test_bodies_of_another_arm_are_refused(tmp_path: Path) -> None:
    (tmp_path / "arm.sdf").write_text(SDF)
    with pytest.raises(ModelError, match="of another arm: the model has no joint waist"):
        export(pair_of({}), "sdf", tmp_path / "arm.sdf", None, BODIES)
