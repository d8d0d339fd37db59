"""What a diagnosis says of recordings whose physics is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, on, recorded, reshaped
from trunk_ros.arm import Arm
from trunk_ros.chain import Chain
from trunk_ros.diagnosis import diagnose
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.simulate import simulate


def test_an_arm_with_nothing_missing_has_no_finding() -> None:
    result = diagnose([recorded()])
    assert result.verdict == "no_mismatch"
    assert result.findings == []
    assert result.unexplained == []


@pytest.mark.parametrize(("counts", "size"), [(2**14, 1.0), (2**12, 0.05), (2**14, 0.05)])
def test_the_steps_of_a_joints_own_encoder_are_no_physics(counts: int, size: float) -> None:
    """Slow joints stand on one count for long, and err the same way."""
    step, slow = 2 * np.pi / counts, recorded(size=size)
    position = recorded(noise=0.03 * step, size=size).series["joint_states"].position
    result = diagnose([reshaped(slow, "joint_states", position=step * np.round(position / step))])
    assert (result.verdict, result.findings, result.unexplained) == ("no_mismatch", [], [])
    for said in result.stages["wire"]["joints"].values():
        assert said["noise_floor"] > 0.99 * step / np.sqrt(12.0)


def test_noise_with_outliers_is_noise() -> None:
    recording = recorded(noise=0.0)
    position = recording.series["joint_states"].position
    tails = NOISE * np.random.default_rng(3).standard_t(3, size=position.shape)
    result = diagnose([reshaped(recording, "joint_states", position=position + tails)])
    assert (result.verdict, result.findings, result.unexplained) == ("no_mismatch", [], [])


def test_a_wheel_out_of_centre_swings_once_a_turn() -> None:
    """On a winch whose shaft turns several times."""
    none, one = np.empty(0), np.ones(1)
    arm = Arm(("drum",), 0.05 * one, 3e-4 * one, -one, one, none, none, none)
    stamp = np.arange(0.0, 50.0, 0.01)
    phi = 9.0 * np.sin(0.4 * stamp)[:, None]
    uneven = {"amplitude": 8e-4 * one, "cycles_per_rev": one, "phase": 0.5 * one}
    theta, _ = Chain(Model(arm, {"transmission_ripple": uneven}), "wire").run(phi, stamp)
    theta += NOISE * np.random.default_rng(0).normal(size=theta.shape)
    angles = {"gearbox_states": phi, "joint_states": theta}
    series = {name: JointSeries(stamp, arm.joints, angle) for name, angle in angles.items()}
    (found,) = diagnose([Recording("winch", 0, 50.0, series)], model=Model(arm)).findings
    assert found.effect == "transmission_ripple"
    assert found.parameters["drum"]["cycles_per_rev"]["value"] == pytest.approx(1.0, abs=0.01)
    assert found.parameters["drum"]["amplitude"]["value"] == pytest.approx(8e-4, rel=0.03)


def test_a_dead_band_and_a_ratio_are_named_on_their_joints_with_their_sizes() -> None:
    recording = recorded({"backlash": {"half_width": on(2, 8e-4)}, "ratio_error": {"relative": on(4, 0.006)}})
    result = diagnose([recording])
    named = {f.effect: f for f in result.findings}
    assert set(named) == {"backlash", "ratio_error"}
    assert named["backlash"].joints == ["joint_2"]
    assert named["ratio_error"].joints == ["joint_4"]
    width = named["backlash"].parameters["joint_2"]["half_width"]
    assert width["value"] == pytest.approx(8e-4, abs=4 * width["std"])
    assert width["unit"] == "rad"
    assert result.verdict == "explained"


def test_the_error_falls_to_the_noise_on_samples_that_the_fit_did_not_see() -> None:
    result = diagnose([recorded({"backlash": {"half_width": on(2, 8e-4)}})])
    joint = result.stages["wire"]["joints"]["joint_2"]
    assert joint["rmse_before"] > 5 * joint["noise_floor"]
    assert joint["rmse_after"] == pytest.approx(joint["noise_floor"], rel=0.1)


def test_the_model_found_predicts_another_run_of_the_same_arm() -> None:
    effects = {"joint_coupling": {"gain": on(5, 0.01), "source": ["", "", "", "", "joint_3"]}}
    result = diagnose([recorded(effects)])
    other = recorded(effects, seed=7, noise=0.0)
    measured = other.series["joint_states"].position[300:]
    error = {
        name: np.sqrt(
            np.mean((simulate(other, model).series["joint_states"].position[300:, 4] - measured[:, 4]) ** 2)
        )
        for name, model in (("before", load_model("trunk")), ("after", result.model))
    }
    assert error["after"] < 0.05 * error["before"]


def test_a_payload_that_the_wires_show_bears_on_the_servo_as_well() -> None:
    """The droop of a servo under load is as large as it is, not as large as the payload makes it look."""
    effects = {"load_elasticity": {"compliance": load_model("trunk").arm.compliance, "payload": 0.06}}
    recording = recorded(effects | {"load_droop": {"gain": 0.05}})
    result = diagnose([recording])
    named = {f.effect: f for f in result.findings}
    assert set(named) == {"load_droop", "load_elasticity"}
    assert named["load_droop"].parameters["arm"]["gain"]["value"] == pytest.approx(0.05, rel=0.02)


@pytest.mark.parametrize(
    "effects",
    [
        {"servo_delay": {"delay": 0.007}, "servo_bandwidth": {"relative": 0.1}},
        {"tension_error": {"factor": 1.7}, "backlash": {"half_width": on(1, 4e-4) + on(4, 6e-4)}},
        {"sensor_delay": {"delay": 0.004}, "backlash": {"half_width": np.full(5, 4e-4)}},
    ],
    ids=lambda effects: "+".join(effects),
)
def test_effects_that_hide_each_other_are_both_named(effects: dict[str, dict[str, Any]]) -> None:
    """A later and a faster servo all but cancel; a tension and dead bands widen the same loops; a dead band
    that is narrower in fast motion takes a part of a delay."""
    result = diagnose([recorded(effects)])
    assert {f.effect for f in result.findings} == set(effects)
    assert result.verdict == "explained"


def test_a_joint_that_stood_somewhere_in_its_play_for_long_is_no_finding() -> None:
    whole = recorded(seconds=50.0, seed=4)
    arm = load_model("trunk").arm
    stood = {}
    for key, offset in (
        ("setpoints", 0.0),
        ("gearbox_states", 0.0),
        ("joint_states", 0.4 * arm.dead_band[4]),
    ):
        position = whole.series[key].position.copy()
        rest = np.median(position[:5, 4]) + offset
        noise = np.random.default_rng(9).normal(size=4000) * 1e-4 if key == "joint_states" else 0.0
        position[:4000, 4] = rest + noise
        stood[key] = replace(whole.series[key], position=position, velocity=None)
    result = diagnose([replace(whole, series={**whole.series, **stood})])
    assert [f.effect for f in result.findings if f.stage == "wire"] == []


def test_a_stop_that_is_hardly_touched_is_a_stop() -> None:
    free = recorded(seed=3, noise=0.0).series["joint_states"].position[:, 1].max()
    upper = np.where(on(2, 1.0) > 0, free - 1.5e-3, np.inf)
    result = diagnose([recorded({"hard_stop": {"upper": upper}}, seed=3)])
    assert [(f.effect, f.joints) for f in result.findings] == [("hard_stop", ["joint_2"])]


def test_a_late_sensor_is_one_delay_of_the_whole_arm() -> None:
    result = diagnose([recorded({"sensor_delay": {"delay": 0.02}})])
    (found,) = result.findings
    assert found.effect == "sensor_delay"
    assert len(found.joints) == 5
    assert found.parameters["arm"]["delay"]["value"] == pytest.approx(0.02, abs=5e-4)


def test_a_slower_servo_is_blamed_on_the_servo_and_not_on_the_wire() -> None:
    result = diagnose([recorded({"servo_bandwidth": {"relative": -0.2}})])
    (found,) = result.findings
    assert (found.effect, found.stage) == ("servo_bandwidth", "servo")
    assert result.model.effects["servo_bandwidth"]["relative"] == pytest.approx(-0.2, abs=0.01)


def test_a_bump_that_no_name_fits_is_unknown_and_its_curve_still_predicts() -> None:
    recording = recorded()
    joints = recording.series["joint_states"]
    bump = 1e-3 * np.exp(-0.5 * ((joints.position[:, 2] - 0.05) / 0.05) ** 2)
    position = joints.position.copy()
    position[:, 2] += bump
    result = diagnose([reshaped(recording, "joint_states", position=position)])
    (found,) = result.findings
    assert (found.effect, found.joints, found.depends_on) == ("unknown", ["joint_3"], ["position"])
    assert result.verdict == "unexplained"
    wire = result.stages["wire"]["joints"]["joint_3"]
    assert wire["rmse_after"] < 1.2 * wire["noise_floor"]


def test_against_another_simulator_its_prediction_is_what_is_doubted() -> None:
    truth = {"backlash": {"half_width": on(1, 1e-3)}, "zero_offset": {"offset": on(3, 2e-3)}}
    real = recorded(truth)
    theirs = simulate(real, replace(load_model("trunk"), effects={"zero_offset": {"offset": on(3, 2e-3)}}))
    result = diagnose([real], against=theirs)
    assert [(f.effect, f.joints) for f in result.findings] == [("backlash", ["joint_1"])]


def test_several_recordings_are_one_arm() -> None:
    effects = {"ratio_error": {"relative": on(2, 0.004)}}
    result = diagnose([recorded(effects, 20.0), recorded(effects, 25.0, seed=3)])
    assert [(f.effect, f.joints) for f in result.findings] == [("ratio_error", ["joint_2"])]


@pytest.mark.parametrize("order", [1, -1])
def test_what_only_one_of_several_recordings_shows_is_found_in_any_order(order: int) -> None:
    """The joint meets its stop in the wide motion alone."""
    upper = np.where(on(2, 1.0) > 0, 0.11, np.inf)
    bags = [recorded({"hard_stop": {"upper": upper}}, seed=2 + k, size=s) for k, s in enumerate((0.3, 1.0))]
    result = diagnose(bags[::order])
    assert [(f.effect, f.joints) for f in result.findings] == [("hard_stop", ["joint_2"])]
    assert result.findings[0].parameters["joint_2"]["upper"]["value"] == pytest.approx(0.11, abs=1e-3)


def test_a_joint_that_hardly_moves_is_said_to_be_silent() -> None:
    recording = recorded()
    still = {}
    for key in ("setpoints", "gearbox_states", "joint_states"):
        position = recording.series[key].position.copy()
        position[:, 3] = position[0, 3]
        still[key] = replace(recording.series[key], position=position)
    result = diagnose([replace(recording, series={**recording.series, **still})])
    assert result.stages["wire"]["silent"] == ["joint_4"]
    assert all("joint_4" not in f.joints for f in result.findings if f.stage == "wire")


def test_the_json_has_the_schema_that_programs_rely_on(tmp_path: Path) -> None:
    result = diagnose([recorded({"backlash": {"half_width": on(2, 8e-4)}})])
    result.save(tmp_path)
    said = json.loads((tmp_path / "diagnosis.json").read_text())
    assert said["schema"] == "trunk_ros/diagnosis/1"
    assert said["verdict"] == "explained"
    assert {"stages", "findings", "unexplained", "experiments"} <= set(said)
    (finding,) = said["findings"]
    assert set(finding["parameters"]["joint_2"]["half_width"]) == {"value", "std", "unit"}
    assert 0.0 <= finding["confidence"] <= 1.0
    assert finding["regime"] == "reversal"
    assert {"unit", "rmse_before", "rmse_after", "noise_floor"} <= set(
        said["stages"]["wire"]["joints"]["joint_2"]
    )
    assert load_model(tmp_path / "model.yaml").hash() == result.model.hash()


def test_what_the_model_has_already_is_no_finding_and_stays_in_it() -> None:
    believed = {"backlash": {"half_width": on(2, 8e-4)}}
    model = replace(load_model("trunk"), effects=believed)
    result = diagnose([recorded(believed)], model=model)
    assert (result.verdict, result.findings) == ("no_mismatch", [])
    assert result.model.effects["backlash"]["half_width"][1] == pytest.approx(8e-4, rel=0.03)


def test_what_the_model_has_not_is_found_beside_what_it_has() -> None:
    model = replace(load_model("trunk"), effects={"backlash": {"half_width": on(2, 8e-4)}})
    truth = {"backlash": {"half_width": on(2, 8e-4)}, "ratio_error": {"relative": on(4, 0.006)}}
    result = diagnose([recorded(truth)], model=model)
    assert [(f.effect, f.joints) for f in result.findings] == [("ratio_error", ["joint_4"])]
    assert set(result.model.effects) == {"backlash", "ratio_error"}


def test_a_joint_named_in_every_second_setpoint_message_holds_the_last_one() -> None:
    whole = recorded()
    asked = whole.series["setpoints"].position.copy()
    asked[1::2, 3] = asked[:-1:2, 3]
    model = load_model("trunk")
    stamp = whole.series["setpoints"].stamp
    phi, _ = Chain(model, "servo").run(asked, stamp)
    theta, _ = Chain(model, "wire").run(phi, stamp)
    theta += NOISE * np.random.default_rng(0).normal(size=theta.shape)
    asked[1::2, 3] = np.nan
    changed = reshaped(whole, "setpoints", position=asked)
    changed = reshaped(changed, "gearbox_states", position=phi, velocity=None)
    assert diagnose([reshaped(changed, "joint_states", position=theta)]).findings == []


def test_servos_are_diagnosed_where_the_joints_have_no_sensors() -> None:
    whole = recorded({"servo_delay": {"delay": 0.02}})
    blind = replace(whole, series={k: v for k, v in whole.series.items() if k != "joint_states"})
    result = diagnose([blind])
    assert [found.effect for found in result.findings] == ["servo_delay"]
    assert not result.stages["wire"]["compared"]


def test_servos_that_are_not_compared_are_said() -> None:
    whole = recorded()
    some = whole.series["setpoints"].select(("joint_1", "joint_2"))
    result = diagnose([replace(whole, series={**whole.series, "setpoints": some})])
    assert not result.stages["servo"]["compared"]
    (quality,) = result.quality.values()
    assert "joint_3, joint_4, joint_5 not there: servos not compared" in " ".join(quality["notes"])


def test_a_zero_that_is_off_and_jumps_is_named_as_both() -> None:
    """Creep over minutes explains more of it than either alone."""
    hidden = {
        "zero_offset": {"offset": on(1, -4.5e-4)},
        "wire_slip": {"step": on(1, 2.4e-4), "onset": np.full(5, 28.0)},
    }
    result = diagnose([recorded(hidden)])
    assert {(f.effect, *f.joints) for f in result.findings} == {
        ("zero_offset", "joint_1"),
        ("wire_slip", "joint_1"),
    }


def test_a_top_speed_that_one_joint_meets_is_the_servos_of_all() -> None:
    hidden = {"velocity_saturation": {"v_max": 0.45}, "servo_delay": {"delay": 0.004}}
    result = diagnose([recorded(hidden, size=0.9)])
    assert {f.effect: len(f.joints) for f in result.findings} == dict.fromkeys(hidden, 5)
