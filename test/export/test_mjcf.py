"""What is written into an MJCF file does in MuJoCo what the model does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.export.arms import KP, KV, MJCF, MOTORS, SERVOS, model_of, pair
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.errors import TrunkError
from trunk_ros.export.run import export
from trunk_ros.export.sheet import Sheet
from trunk_ros.model import load_model, save_model

mujoco = pytest.importorskip("mujoco")

TICK, PER = 0.01, 10
STAMP = np.arange(2000) * TICK
RISE = np.clip(STAMP / 2.0, 0.0, 1.0)[:, None]
COMMANDS = RISE * 0.4 * np.sin(2 * np.pi * STAMP[:, None] * [0.15, 0.1])


def written(effects: dict[str, Any], tmp_path: Path, drives: str = SERVOS) -> tuple[Sheet, Any]:
    """The sheet of an export, and the model that MuJoCo makes of it."""
    (tmp_path / "arm.xml").write_text(MJCF.format(drives=drives))
    sheet = export(model_of(effects), "mjcf", tmp_path / "arm.xml")
    return sheet, mujoco.MjModel.from_xml_string(sheet.text)


def moved(model: Any, sensors: bool = False) -> Array:
    """Joint angles (n, 2) rad under the commands, or what the sensors show."""
    data, out = mujoco.MjData(model), np.empty_like(COMMANDS)
    for k, command in enumerate(COMMANDS):
        out[k] = data.sensordata if sensors else data.qpos
        data.ctrl[:] = command
        mujoco.mj_step(model, data, PER)
    return out


def error(sheet: Sheet, model: Any, effects: dict[str, Any], plain: Any, sensors: bool = False) -> float:
    """How much of what the effects do the exported file lacks, rms."""
    assert not sheet.layer.effects
    bare, done = moved(plain), moved(model, sensors)
    wanted = Chain(model_of(effects), "wire").run(bare, STAMP)[0]
    left, whole = (np.sqrt(np.mean((x - wanted)[300:] ** 2)) for x in (done, bare))
    return float(left / whole)


@pytest.mark.parametrize(
    ("effects", "most"),
    [
        ({"backlash": {"half_width": pair(8e-3, 4e-3)}}, 0.12),
        ({"backlash": {"half_width": pair(8e-3)}, "load_elasticity": {"compliance": pair(0.01)}}, 0.12),
        ({"ratio_error": {"relative": pair(0.03, -0.05)}}, 0.01),
        ({"joint_coupling": {"gain": pair(0.0, 0.1), "source": ["", "shoulder"]}}, 0.02),
        ({"viscous_lag": {"time_constant": pair(0.05, 0.03)}}, 0.1),
        ({"hard_stop": {"upper": pair(0.3, 100.0), "form": "upper"}}, 0.05),
    ],
)
def test_native_terms_do_what_the_effect_does(effects: dict[str, Any], most: float, tmp_path: Path) -> None:
    sheet, model = written(effects, tmp_path)
    plain = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    assert error(sheet, model, effects, plain) < most


def test_a_sensor_delay_is_the_sensors_own(tmp_path: Path) -> None:
    effects = {"sensor_delay": {"delay": 0.04}}
    sheet, model = written(effects, tmp_path)
    plain = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    assert error(sheet, model, effects, plain, sensors=True) < 0.1


def test_a_servo_delay_is_the_actuators_own(tmp_path: Path) -> None:
    sheet, model = written({"servo_delay": {"delay": 0.05}}, tmp_path)
    assert not sheet.layer.effects
    late, prompt = moved(model), moved(mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml")))
    assert np.abs(late[5:] - prompt[:-5])[300:].max() < 0.03 * np.abs(late - prompt).max()


def test_an_actuator_that_is_in_time_stays_as_it_is(tmp_path: Path) -> None:
    sheet, model = written({"servo_delay": {"delay": pair(0.02, 0.0)}}, tmp_path)
    assert len(sheet.lines) == 1
    assert (model.actuator_delay > 0.0).tolist() == [True, False]


def test_the_layer_knows_of_a_gain_that_the_file_has(tmp_path: Path) -> None:
    slow = {"velocity_loop": {"relative": 1.0}, "servo_bandwidth": {"relative": -0.2}}
    sheet, _ = written(slow, tmp_path)
    assert set(sheet.layer.effects) == {"velocity_loop"}
    save_model(sheet.layer, tmp_path / "arm.reality.yaml")
    layer = load_model(tmp_path / "arm.reality.yaml")
    np.testing.assert_allclose(layer.arm.kp, 0.8 * model_of({}).arm.kp)


def test_a_spring_in_series_is_less_stiffness_at_the_same_speed(tmp_path: Path) -> None:
    sheet, model = written({"load_elasticity": {"compliance": pair(0.01, 0.0)}}, tmp_path)
    assert model.actuator("shoulder_drive").gainprm[0] == pytest.approx(1 / (1 / KP + 0.01))
    ratio = model.actuator("shoulder_drive").biasprm[2] / model.actuator("shoulder_drive").biasprm[1]
    assert ratio == pytest.approx(KV / KP)
    assert model.actuator("elbow_drive").gainprm[0] == KP
    assert "trunk_ros: load_elasticity 0.01 rad/(N m): kp, kv" in sheet.text


def test_a_payload_is_a_mass_and_its_sag_is_the_layers(tmp_path: Path) -> None:
    sag = {"load_elasticity": {"compliance": pair(1e-3, 1e-3), "payload": 0.05}}
    sheet, model = written(sag, tmp_path)
    assert model.body("payload").mass[0] == pytest.approx(0.05)
    assert model.actuator("shoulder_drive").gainprm[0] == KP
    assert sheet.layer.payload == 0.05
    sheet, model = written({**sag, "load_droop": {"gain": -1e-3}}, tmp_path)
    assert "payload" not in [model.body(k).name for k in range(model.nbody)]
    assert "the servos' findings have what it does to the motors" in sheet.remarks[0]


def test_under_a_bare_motor_a_play_is_a_joint_of_its_own(tmp_path: Path) -> None:
    sheet, model = written({"backlash": {"half_width": pair(0.0, 4e-3)}}, tmp_path, MOTORS)
    assert model.joint("elbow_backlash").range == pytest.approx([-4e-3, 4e-3])
    assert model.tendon_frictionloss[model.tendon("elbow_link").id] > 0.0
    assert not sheet.layer.effects
    assert any("elbow_link" in remark for remark in sheet.remarks)


def test_geometry_is_written_where_it_is(tmp_path: Path) -> None:
    effects = {
        "link_length_error": {"length_error": pair(2e-3, -1e-3)},
        "base_tilt": {"angle": 0.02},
    }
    _, model = written(effects, tmp_path)
    assert model.body("lower").pos == pytest.approx([0, 0, 0.202])
    assert model.site("tip").pos == pytest.approx([0, 0, 0.149])
    assert model.body("upper").quat == pytest.approx([np.cos(0.01), np.sin(0.01), 0, 0])


def test_what_mujoco_cannot_say_is_left_with_its_size(tmp_path: Path) -> None:
    effects = {
        "presliding_hysteresis": {"width": pair(3e-3, 0.0), "form": "dahl"},
        "transmission_ripple": {"amplitude": pair(0, 1e-3), "cycles_per_rev": pair(4, 4), "phase": pair()},
    }
    sheet, _ = written(effects, tmp_path)
    assert sheet.lines == []
    assert set(sheet.layer.effects) == set(effects)
    assert "presliding_hysteresis: width shoulder 0.003 rad" in sheet.left


def test_a_lag_that_is_no_damping_is_left_to_the_layer(tmp_path: Path) -> None:
    for form in ("shift", "proportional"):
        effects = {"viscous_lag": {"time_constant": pair(0.05, 0.03), "form": form}}
        sheet, model = written(effects, tmp_path)
        assert (sheet.lines, set(sheet.layer.effects)) == ([], {"viscous_lag"})
        assert not model.dof_damping.any()


def test_files_that_are_none_are_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text("<mujoco><bodies/></mujoco>")
    with pytest.raises(TrunkError, match=r"arm.xml: MuJoCo cannot read it"):
        export(model_of({}), "mjcf", tmp_path / "arm.xml")
    (tmp_path / "arm.xml").write_text(
        '<mujoco><worldbody><body><joint name="hip"/><geom size="1"/></body></worldbody></mujoco>'
    )
    with pytest.raises(TrunkError, match=r"none of the joints shoulder, elbow is in it \(there are hip\)"):
        export(model_of({}), "mjcf", tmp_path / "arm.xml")
