"""The load from the motors' torque: friction taken off, weight recovered, used where the model says so."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import SHORT, TRUNK, diagnose, of_the_wires, reshaped
from trunk_ros.arm import Arm
from trunk_ros.commands.simulate import main
from trunk_ros.compiled import Array
from trunk_ros.data.align import servo_span, wire_span
from trunk_ros.data.load_cells import cell_remarks
from trunk_ros.data.torque import torque_remarks
from trunk_ros.effort import measured_load
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording
from trunk_ros.simulate import simulate

NOMINAL = SHORT
recorded = partial(arms.recorded, nominal=SHORT)
FRICTION = np.array([0.01, 0.008, 0.015])  # N m at the shaft
SECONDS = 20.0
SAG = {"load_elasticity": {"compliance": np.full(3, 0.04)}}


def taken_from(load: str, effects: dict[str, Any] | None = None) -> Model:
    """The nominal model with its load from elsewhere."""
    return Model(replace(NOMINAL.arm, load_from=load), effects or {})


def weight(recording: Recording, arm: Arm = NOMINAL.arm) -> Array:
    """Moment on the joints (n, joints) N m at the gearbox's stamps."""
    return arm.load(recording.series["gearbox_states"].position * arm.ratio)


def with_torque(recording: Recording, load: Array, noise: float = 2e-4) -> Recording:
    """Effort as the topic's users expect it: against the load, plus friction in the direction of motion."""
    gearbox = recording.series["gearbox_states"]
    assert gearbox.velocity is not None
    torque = -0.625 * load + np.resize(FRICTION, load.shape[1]) * np.sign(gearbox.velocity)
    rough = noise * np.random.default_rng(7).normal(size=load.shape)
    return reshaped(recording, "gearbox_states", effort=torque + rough)


@pytest.fixture(scope="module")
def plain() -> Recording:
    return recorded(SAG, 40.0)


def test_friction_comes_off_and_the_weight_is_left(plain: Recording) -> None:
    made = with_torque(plain, weight(plain))
    got = measured_load(made.series["gearbox_states"], NOMINAL.arm.ratio)
    assert got.friction == pytest.approx(FRICTION, rel=0.01)
    assert np.sqrt(np.mean((got.moment - weight(plain)) ** 2)) < 2e-4
    assert np.abs(got.moment - weight(plain)).max() < 2e-3


def test_a_shaft_that_stands_carries_what_its_posture_asks_for() -> None:
    """Joint 3 rests for 15 s, its friction may hold anything; the others move its load on."""
    made = recorded(SAG, seconds=60.0)
    gearbox = made.series["gearbox_states"]
    phi, stamp = gearbox.position.copy(), gearbox.stamp
    rests = (stamp > 20.0) & (stamp < 35.0)
    phi[:, 2] = np.interp(stamp - np.clip(stamp - 20.0, 0.0, 15.0), stamp, phi[:, 2])
    made = reshaped(made, "gearbox_states", position=phi, velocity=np.gradient(phi, stamp, axis=0))
    held = with_torque(made, weight(made))
    torque = held.series["gearbox_states"].effort
    assert torque is not None
    torque[rests, 2] += 0.012
    got = measured_load(held.series["gearbox_states"], NOMINAL.arm.ratio)
    assert not got.moving[rests, 2].any()
    assert np.abs(got.moment - weight(made))[rests, 2].max() < 1e-3


def test_a_joint_that_goes_one_way_only_keeps_its_computed_weight(plain: Recording) -> None:
    gearbox = plain.series["gearbox_states"]
    phi = gearbox.position.copy()
    phi[:, 1] = 0.005 * gearbox.stamp
    slope = np.gradient(phi, gearbox.stamp, axis=0)
    one_way = reshaped(plain, "gearbox_states", position=phi, velocity=slope)
    made = with_torque(one_way, weight(one_way))
    got = measured_load(made.series["gearbox_states"], NOMINAL.arm.ratio)
    assert np.isnan(got.friction[1])
    assert np.isnan(got.moment[:, 1]).all()
    effort, computed = (
        simulate(made, taken_from(load, SAG)).series["joint_states"].position[:, 1]
        for load in ("effort", "weight")
    )
    assert effort == pytest.approx(computed, abs=1e-4)
    assert "computed weight on joint_2" in torque_remarks(made, taken_from("effort"))[0]


def test_an_arm_of_one_joint_and_a_urdf_has_its_weight_from_its_torque() -> None:
    text = (
        '<robot name="arm"><link name="base"/><link name="link"><inertial><origin xyz="0 0 0.1"/>'
        '<mass value="1"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="elbow" type="revolute"><parent link="base"/><child link="link"/><axis xyz="1 0 0"/>'
        '<limit lower="-2" upper="2" velocity="9" effort="9"/></joint></robot>'
    )
    arm = load_model("direct").with_urdf(text, ("elbow",)).arm
    stamp = np.arange(0.0, 20.0, 0.01)
    angle = 0.8 * np.sin(stamp)[:, None]
    torque = 0.1 * np.sign(np.cos(stamp))[:, None] - arm.load(angle)
    got = measured_load(JointSeries(stamp, ("elbow",), angle, None, torque), arm.ratio, arm)
    assert got.moment == pytest.approx(arm.load(angle), abs=5e-3)
    assert got.friction == pytest.approx([0.1], rel=0.02)


def heavier(payload: float = 0.05) -> Recording:
    """A run of an arm with a payload that the nominal model knows nothing of."""
    made = recorded({"load_elasticity": {**SAG["load_elasticity"], "payload": payload}}, SECONDS)
    return with_torque(made, weight(made, replace(NOMINAL.arm, payload=payload)))


def rms_off(made: Recording, model: Model) -> float:
    """Prediction less measured [rad], once the play is engaged."""
    shown = simulate(made, model).series["joint_states"].position
    return float(np.sqrt(np.mean((shown - made.series["joint_states"].position)[400:] ** 2)))


def test_a_simulation_with_effort_knows_a_payload_that_the_model_does_not() -> None:
    made = heavier()
    assert rms_off(made, taken_from("weight", SAG)) > 5e-4
    assert rms_off(made, taken_from("effort", SAG)) == pytest.approx(1e-4, rel=0.1)


def test_without_effort_the_weight_is_computed_and_the_report_says_so(plain: Recording) -> None:
    assert rms_off(plain, taken_from("effort", SAG)) == rms_off(plain, taken_from("weight", SAG))
    assert torque_remarks(plain, taken_from("effort")) == [
        "no effort in gearbox_states: the load is the computed weight"
    ]
    assert torque_remarks(plain, NOMINAL) == []


def test_torque_that_agrees_with_the_weight_is_not_worth_a_remark(plain: Recording) -> None:
    assert torque_remarks(with_torque(plain, weight(plain)), NOMINAL) == []


def test_torque_that_shows_the_inertia_as_well_agrees_with_the_weight(plain: Recording) -> None:
    gearbox = plain.series["gearbox_states"]
    theta = gearbox.position * 0.625
    speed = np.gradient(theta, gearbox.stamp, axis=0)
    swing = NOMINAL.arm.inertia(theta, speed, np.gradient(speed, gearbox.stamp, axis=0))
    assert torque_remarks(with_torque(plain, weight(plain) + swing), NOMINAL) == []


def test_torque_tells_of_a_payload() -> None:
    (said,) = torque_remarks(heavier(), NOMINAL)
    assert said.endswith("50 g more at the tip would explain it")


def test_torque_tells_of_a_wrong_mass_that_is_no_payload(plain: Recording) -> None:
    other = replace(NOMINAL.arm, link_mass=NOMINAL.arm.link_mass * [1.0, 4.0, 1.0])
    (said,) = torque_remarks(with_torque(plain, weight(plain, other)), NOMINAL)
    assert "check masses" in said


def test_torque_is_compared_by_the_ratio_that_was_found(plain: Recording) -> None:
    made, ideal = with_torque(plain, weight(plain)), Model(replace(NOMINAL.arm, ratio=np.ones(3)))
    assert "differ by" in torque_remarks(made, ideal)[0]
    assert torque_remarks(made, ideal, replace(ideal, effects={"ratio_error": {"relative": -0.375}})) == []
    motors = replace(made, series={"gearbox_states": made.series["gearbox_states"]})
    assert torque_remarks(motors, ideal) == []


def test_torque_is_not_compared_with_a_weight_where_there_is_no_gravity(plain: Recording) -> None:
    afloat = Model(replace(NOMINAL.arm, gravity=0.0))
    assert torque_remarks(with_torque(plain, weight(plain)), afloat) == []


def test_torque_tells_of_a_joint_that_was_to_bear_nothing(plain: Recording) -> None:
    light = Model(replace(NOMINAL.arm, link_mass=NOMINAL.arm.link_mass * [1.0, 1.0, 0.0]))
    pull = arms.on(3, 0.5, joints=3) * np.sin(plain.series["gearbox_states"].position)
    (said,) = torque_remarks(with_torque(plain, weight(plain) + pull), light)
    assert "joint_3 most, where none was computed" in said


def test_the_command_simulates_with_effort_from_a_bag(tmp_path: Path) -> None:
    made = heavier()
    write_recording(tmp_path / "run", made)
    save_model(taken_from("effort", SAG), tmp_path / "model.yaml")
    run, model, out = (str(tmp_path / name) for name in ("run", "model.yaml", "out"))
    assert main([run, "--model", model, "--output", out]) == 0
    shown, again = (
        each.series["joint_states"] for each in (read_recording(out), simulate(made, load_model(model)))
    )
    assert shown.position == pytest.approx(again.position)


@pytest.mark.timeout(240)
@pytest.mark.parametrize("load", ["weight_and_inertia", "effort"])
def test_a_diagnosis_names_the_stretch_whatever_the_load_is_taken_from(load: str) -> None:
    """With effort, of an arm whose payload nobody has told."""
    made = heavier() if load == "effort" else swung_arm()
    result = diagnose([of_the_wires(made)], taken_from(load))
    (found,) = result.findings
    assert found.effect == "load_elasticity"
    assert found.parameters["joint_1"]["compliance"]["value"] == pytest.approx(0.04, rel=0.05)
    assert result.model.arm.load_from == load
    assert rms_off(made, result.model) == pytest.approx(1e-4, rel=0.1)


def test_with_effort_the_stretch_is_named_on_an_arm_whose_masses_nobody_knows() -> None:
    arm = replace(NOMINAL.arm, load_from="effort", link_mass=np.empty(0), link_length=np.empty(0))
    (found,) = diagnose([of_the_wires(heavier())], Model(arm)).findings
    assert found.effect == "load_elasticity"
    assert found.parameters["joint_1"]["compliance"]["value"] == pytest.approx(0.04, rel=0.05)


@pytest.mark.timeout(240)
def test_with_effort_a_compliance_that_changes_with_the_angle_is_told() -> None:
    lever = {"compliance": np.full(5, 0.04), "form": "lever", "slope": np.full(5, 0.8)}
    made = arms.recorded({"load_elasticity": lever}, SECONDS)
    five = Model(replace(TRUNK.arm, load_from="effort"))
    (found,) = diagnose([of_the_wires(with_torque(made, weight(made, TRUNK.arm)))], five).findings
    assert (found.effect, found.evidence["form"]) == ("load_elasticity", "lever")
    assert found.parameters["joint_1"]["slope"]["value"] == pytest.approx(0.8, rel=0.15)
    assert found.parameters["joint_1"]["compliance"]["value"] == pytest.approx(0.04, rel=0.05)


def swung_arm() -> Recording:
    """A run of an arm that stretches under weight and inertia."""
    made = recorded(seconds=SECONDS)
    shown = simulate(made, taken_from("weight_and_inertia", SAG)).series["joint_states"]
    noise = 1e-4 * np.random.default_rng(2).normal(size=shown.position.shape)
    return reshaped(made, "joint_states", position=shown.position + noise)


def test_a_payload_that_the_model_has_already_is_counted_once() -> None:
    known = Model(NOMINAL.arm, {"load_elasticity": {**SAG["load_elasticity"], "payload": 0.1}})
    result = diagnose([of_the_wires(recorded(dict(known.effects), SECONDS))], known)
    assert result.verdict == "no_mismatch"
    assert result.model.payload == pytest.approx(0.1, abs=2e-3)


def test_what_load_cells_at_the_joints_tell_is_the_load() -> None:
    """Hands push at two joints, whose masses are not known; the cells tell how strongly."""
    t = np.arange(0.0, 40.0, 0.01)

    def pushed(seed: int) -> Recording:
        rng = np.random.default_rng(seed)
        path = np.column_stack([0.6 * np.sin(2 * np.pi * f * t) for f in (0.11, 0.17)])
        push = np.column_stack([np.interp(t, np.arange(0, 41, 2), rng.uniform(-0.5, 0.5, 21)) for _ in "ab"])
        shown = path + 0.05 * push + 1e-4 * rng.standard_normal(path.shape)
        joints = ("a", "b")
        series = {
            "gearbox_states": JointSeries(t, joints, path),
            "joint_states": JointSeries(t, joints, shown, effort=push),
        }
        return Recording("pushed", 0, float(t[-1]), series)

    found = diagnose(pushed(1), model="direct")
    (finding,) = found.findings
    assert finding.effect == "load_elasticity"
    for values in finding.parameters.values():
        assert values["compliance"]["value"] == pytest.approx(0.05, rel=0.01)
    other = pushed(2)
    off = simulate(other, found.model).series["joint_states"].position - other.series["joint_states"].position
    assert off.std() < 1.1e-4


def cells_of(recording: Recording, told: Array) -> Recording:
    """With an effort (n, joints) N m of the joints' own sensors, at the stamps of the gearbox."""
    at, shown = recording.series["gearbox_states"].stamp, recording.series["joint_states"].stamp
    return reshaped(
        recording, "joint_states", effort=np.column_stack([np.interp(shown, at, column) for column in told.T])
    )


def test_one_load_cell_leaves_the_weight_on_the_other_joints(plain: Recording) -> None:
    told = np.where(np.arange(3) == 2, weight(plain), np.nan)
    made = cells_of(plain, told)
    known = wire_span(made, taken_from("effort")).resistance
    assert known is not None
    np.testing.assert_allclose(known.moment.std(axis=0), weight(plain).std(axis=0), rtol=0.02)
    assert rms_off(made, taken_from("effort", SAG)) == pytest.approx(1e-4, rel=0.1)
    assert cell_remarks(made, taken_from("effort")) == ["load on joint_3 from effort of joint_states"]


def test_servos_bear_what_the_load_cells_tell(plain: Recording) -> None:
    made = cells_of(plain, 2.0 * weight(plain))
    series = {**made.series, "setpoints": replace(made.series["gearbox_states"], velocity=None, effort=None)}
    known = servo_span(replace(made, series=series), taken_from("effort")).resistance
    assert known is not None
    assert known.moment.std(axis=0) == pytest.approx(2.0 * weight(plain).std(axis=0), rel=0.02)


@pytest.mark.parametrize("masses", [True, False])
def test_a_motors_torque_in_the_place_of_a_load_is_said(plain: Recording, masses: bool) -> None:
    """As ros2_control publishes it: against the weight, and with the motion."""
    own = taken_from("effort") if masses else load_model("direct")
    torque = with_torque(plain, weight(plain)).series["gearbox_states"].effort
    assert torque is not None
    wrong, right = (cell_remarks(cells_of(plain, told), own) for told in (torque, weight(plain)))
    assert len(right) == 1
    (said,) = wrong[1:]
    assert said.startswith("effort of joint_states is a motor's torque on joint_1, joint_2")
