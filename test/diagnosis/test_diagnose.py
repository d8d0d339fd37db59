"""What a diagnosis says of recordings whose physics is known."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import NOISE, SHORT, of_the_wires, reshaped
from trunk_ros.arm import Arm
from trunk_ros.chain import Chain
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.simulate import simulate

on = partial(arms.on, joints=3)
recorded = partial(arms.recorded, nominal=SHORT)
diagnose = partial(arms.diagnose, model=SHORT)


@pytest.fixture(scope="module")
def loose() -> Diagnosis:
    """An arm whose second joint has more play than it should."""
    return diagnose([recorded({"backlash": {"half_width": on(2, 8e-4)}})])


def test_an_arm_with_nothing_missing_has_no_finding() -> None:
    result = arms.diagnose([arms.recorded()])
    assert result.verdict == "no_mismatch"
    assert result.findings == []
    assert result.unexplained == []


@pytest.mark.parametrize(("counts", "size"), [(2**14, 1.0), (2**12, 0.05), (2**14, 0.05)])
def test_the_steps_of_a_joints_own_encoder_are_no_physics(counts: int, size: float) -> None:
    """Slow joints stand on one count for long, and err the same way."""
    step, slow = 2 * np.pi / counts, recorded(size=size)
    position = recorded(noise=0.03 * step, size=size).series["joint_states"].position
    rounded = reshaped(slow, "joint_states", position=step * np.round(position / step))
    result = diagnose([of_the_wires(rounded)])
    assert (result.verdict, result.findings, result.unexplained) == ("no_mismatch", [], [])
    for said in result.stages["wire"]["joints"].values():
        assert said["noise_floor"] > 0.99 * step / np.sqrt(12.0)


def test_noise_with_outliers_is_noise() -> None:
    recording = recorded(noise=0.0)
    position = recording.series["joint_states"].position
    tails = NOISE * np.random.default_rng(3).standard_t(3, size=position.shape)
    result = diagnose([of_the_wires(reshaped(recording, "joint_states", position=position + tails))])
    assert (result.verdict, result.findings, result.unexplained) == ("no_mismatch", [], [])


def test_sensors_that_average_are_late_and_round_no_reversal() -> None:
    """Six readings of 100 Hz: corners are rounded as by a friction that gives before it slides."""
    recording = recorded({"backlash": {"half_width": on(3, 2e-3)}}, noise=0.0)
    position = recording.series["joint_states"].position
    last = np.lib.stride_tricks.sliding_window_view(np.vstack([position[:1]] * 5 + [position]), 6, axis=0)
    read = last.mean(axis=2) + NOISE * np.random.default_rng(3).normal(size=position.shape)
    result = diagnose([of_the_wires(reshaped(recording, "joint_states", position=read))])
    assert result.verdict == "explained"
    late, loose = sorted(result.findings, key=lambda finding: finding.effect, reverse=True)
    assert late.effect == "sensor_delay"
    assert late.parameters["arm"]["delay"]["value"] == pytest.approx(0.025, abs=1e-3)
    assert late.parameters["arm"]["share"]["value"] == pytest.approx(1.2, abs=0.05)
    assert loose.effect == "backlash"


def uneven_winch(**wave: float | str) -> dict[str, Any]:
    """What is found of wheels out of centre on a winch whose shaft turns several times."""
    none, one = np.empty(0), np.ones(1)
    arm = Arm(("drum",), 0.05 * one, 3e-4 * one, -one, one, none, none, none)
    stamp = np.arange(0.0, 50.0, 0.01)
    phi = 9.0 * np.sin(0.4 * stamp)[:, None]
    uneven = {name: value if isinstance(value, str) else value * one for name, value in wave.items()}
    theta, _ = Chain(Model(arm, {"transmission_ripple": uneven}), "wire").run(phi, stamp)
    theta += NOISE * np.random.default_rng(0).normal(size=theta.shape)
    angles = {"gearbox_states": phi, "joint_states": theta}
    series = {name: JointSeries(stamp, arm.joints, angle) for name, angle in angles.items()}
    (found,) = arms.diagnose([Recording("winch", 0, 50.0, series)], model=Model(arm)).findings
    assert found.effect == "transmission_ripple"
    return {name: value["value"] for name, value in found.parameters["drum"].items()}


def test_a_wheel_out_of_centre_swings_once_a_turn() -> None:
    found = uneven_winch(amplitude=8e-4, cycles_per_rev=1.0, phase=0.5)
    assert found["cycles_per_rev"] == pytest.approx(1.0, abs=0.01)
    assert found["amplitude"] == pytest.approx(8e-4, rel=0.03)


def test_two_wheels_out_of_centre_are_two_waves_of_their_own() -> None:
    wave = {"amplitude": 8e-4, "cycles_per_rev": 3.0, "phase": 0.5}
    found = uneven_winch(**wave, harmonic=0.6, harmonic_phase=1.2, cycles_per_rev_2=7.4, form="two_orders")
    assert found["cycles_per_rev"] == pytest.approx(3.0, abs=0.01)
    assert found["cycles_per_rev_2"] == pytest.approx(7.4, abs=0.02)
    assert found["harmonic"] == pytest.approx(0.6, abs=0.05)


def test_the_error_falls_to_the_noise_on_samples_that_the_fit_did_not_see(loose: Diagnosis) -> None:
    joint = loose.stages["wire"]["joints"]["joint_2"]
    assert joint["rmse_before"] > 5 * joint["noise_floor"]
    assert joint["rmse_after"] == pytest.approx(joint["noise_floor"], rel=0.1)


def test_a_wire_that_only_drags_its_neighbour_along_is_found_and_is_no_noise() -> None:
    drag = {"form": "drag", "drag": on(3, 1.0), "reach": on(3, 3e-3), "source": ["", "", "joint_2"]}
    result = diagnose([of_the_wires(recorded({"joint_coupling": drag}))], experiments=False)
    (found,) = result.findings
    values = {name: said["value"] for name, said in found.parameters["joint_3"].items()}
    assert (found.effect, found.joints, found.evidence["form"]) == ("joint_coupling", ["joint_3"], "drag")
    assert values["drag"] == pytest.approx(1.0, rel=0.05)
    assert values["reach"] == pytest.approx(3e-3, rel=0.05)
    assert found.confidence > 0.9
    assert "drags" in found.statement


@pytest.mark.parametrize(
    ("effect", "form", "gain"),
    [
        ("joint_coupling", "angle", 0.01),
        ("joint_coupling", "behind", 0.01),
        ("joint_coupling", "motors", 0.1),
        ("posture_ratio", "", 0.03),
        ("wrap_friction", "bent", 3e-3),
    ],
)
def test_the_model_found_predicts_another_run_of_the_same_arm(effect: str, form: str, gain: float) -> None:
    effects = {
        effect: {"gain": on(3, gain), "source": ["", "", "joint_2"], **({"form": form} if form else {})}
    }
    result = diagnose([of_the_wires(recorded(effects))])
    (found,) = result.findings
    values = {name: said["value"] for name, said in found.parameters["joint_3"].items()}
    assert (found.effect, found.joints) == (effect, ["joint_3"])
    assert values == {"gain": pytest.approx(gain, rel=0.05), "source": "joint_2"}
    assert found.evidence["form"] == form or form == "angle"  # which the motion hardly tells
    other = recorded(effects, seed=7, noise=0.0)
    measured = other.series["joint_states"].position[300:]
    error = {
        name: np.sqrt(
            np.mean((simulate(other, model).series["joint_states"].position[300:, 2] - measured[:, 2]) ** 2)
        )
        for name, model in (("before", SHORT), ("after", result.model))
    }
    assert error["after"] < 0.05 * error["before"]


def test_a_joint_that_stood_somewhere_in_its_play_for_long_is_no_finding() -> None:
    whole = recorded(seconds=50.0, seed=4)
    arm = SHORT.arm
    stood = {}
    for key, offset in (
        ("setpoints", 0.0),
        ("gearbox_states", 0.0),
        ("joint_states", 0.4 * arm.dead_band[2]),
    ):
        position = whole.series[key].position.copy()
        rest = np.median(position[:5, 2]) + offset
        noise = np.random.default_rng(9).normal(size=4000) * 1e-4 if key == "joint_states" else 0.0
        position[:4000, 2] = rest + noise
        stood[key] = replace(whole.series[key], position=position, velocity=None)
    result = diagnose([of_the_wires(replace(whole, series={**whole.series, **stood}))])
    assert result.findings == []


def test_a_stop_that_is_hardly_touched_is_a_stop() -> None:
    free = recorded(seed=3, noise=0.0).series["joint_states"].position[:, 1].max()
    upper = np.where(on(2, 1.0) > 0, free - 1.5e-3, np.inf)
    result = diagnose([of_the_wires(recorded({"hard_stop": {"upper": upper}}, seed=3))])
    assert [(f.effect, f.joints) for f in result.findings] == [("hard_stop", ["joint_2"])]


def test_a_stop_as_soft_as_the_wire_is_a_stop() -> None:
    free = recorded(seed=3, noise=0.0).series["joint_states"].position[:, 1].max()
    stop = {"hard_stop": {"upper": np.where(on(2, 1.0) > 0, 0.5 * free, np.inf), "give": 0.55 * on(2, 1.0)}}
    result = diagnose([of_the_wires(recorded(stop, seed=3))])
    assert [(f.effect, f.joints) for f in result.findings] == [("hard_stop", ["joint_2"])]


def test_a_stop_that_holds_the_joint_most_of_the_time_is_a_stop() -> None:
    mostly = np.quantile(recorded(seed=3, noise=0.0).series["joint_states"].position[:, 1], 0.2)
    upper = np.where(on(2, 1.0) > 0, mostly, np.inf)
    result = diagnose([of_the_wires(recorded({"hard_stop": {"upper": upper}}, seed=3))])
    (found,) = result.findings
    assert (found.effect, found.joints) == ("hard_stop", ["joint_2"])
    assert found.parameters["joint_2"]["upper"]["value"] == pytest.approx(mostly, abs=1e-3)


def test_a_late_sensor_is_one_delay_of_the_whole_arm() -> None:
    result = diagnose([of_the_wires(recorded({"sensor_delay": {"delay": 0.02}}))])
    (found,) = result.findings
    assert found.effect == "sensor_delay"
    assert len(found.joints) == 3
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
    result = diagnose([of_the_wires(reshaped(recording, "joint_states", position=position))])
    (found,) = result.findings
    assert (found.effect, found.joints, found.depends_on) == ("unknown", ["joint_3"], ["position"])
    assert result.verdict == "unexplained"
    wire = result.stages["wire"]["joints"]["joint_3"]
    assert wire["rmse_after"] < 1.2 * wire["noise_floor"]


def test_a_joint_that_hardly_moves_is_said_to_be_silent() -> None:
    recording = recorded()
    still = {}
    for key in ("gearbox_states", "joint_states"):
        position = recording.series[key].position.copy()
        position[:, 2] = position[0, 2]
        still[key] = replace(recording.series[key], position=position)
    result = diagnose([of_the_wires(replace(recording, series={**recording.series, **still}))])
    assert result.stages["wire"]["silent"] == ["joint_3"]
    assert all("joint_3" not in f.joints for f in result.findings if f.stage == "wire")


def test_the_json_has_the_schema_that_programs_rely_on(tmp_path: Path, loose: Diagnosis) -> None:
    loose.save(tmp_path)
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
    assert load_model(tmp_path / "model.yaml").hash() == loose.model.hash()


def test_a_joint_named_in_every_second_setpoint_message_holds_the_last_one() -> None:
    whole = recorded()
    asked = whole.series["setpoints"].position.copy()
    asked[1::2, 2] = asked[:-1:2, 2]
    model = SHORT
    stamp = whole.series["setpoints"].stamp
    phi, _ = Chain(model, "servo").run(asked, stamp)
    theta, _ = Chain(model, "wire").run(phi, stamp)
    theta += NOISE * np.random.default_rng(0).normal(size=theta.shape)
    asked[1::2, 2] = np.nan
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
    assert "joint_3 not there: servos not compared" in " ".join(quality["notes"])
