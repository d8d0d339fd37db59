"""What a diagnosis says where several things come together: effects, recordings, a model that knows some."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import PAIR, SHORT, TRUNK, of_the_servos, of_the_wires
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate

on = partial(arms.on, joints=3)
recorded = partial(arms.recorded, nominal=SHORT)
diagnose = partial(arms.diagnose, model=SHORT)


def test_a_dead_band_and_a_ratio_are_named_on_their_joints_with_their_sizes() -> None:
    hidden = {"backlash": {"half_width": on(2, 8e-4)}, "ratio_error": {"relative": on(3, 0.006)}}
    result = diagnose([of_the_wires(recorded(hidden, seconds=20.0))])
    named = {f.effect: f for f in result.findings}
    assert set(named) == {"backlash", "ratio_error"}
    assert named["backlash"].joints == ["joint_2"]
    assert named["ratio_error"].joints == ["joint_3"]
    width = named["backlash"].parameters["joint_2"]["half_width"]
    assert width["value"] == pytest.approx(8e-4, abs=4 * width["std"])
    assert width["unit"] == "rad"
    assert result.verdict == "explained"


def test_a_payload_that_the_wires_show_bears_on_the_servo_as_well() -> None:
    """The droop of a servo under load is as large as it is, not as large as the payload makes it look."""
    effects = {"load_elasticity": {"compliance": SHORT.arm.compliance, "payload": 0.06}}
    recording = recorded(effects | {"load_droop": {"gain": 0.05}}, seconds=12.0)
    result = diagnose([recording])
    named = {f.effect: f for f in result.findings}
    assert set(named) == {"load_droop", "load_elasticity"}
    assert named["load_droop"].parameters["arm"]["gain"]["value"] == pytest.approx(0.05, rel=0.02)


@pytest.mark.parametrize(
    ("effects", "nominal", "seen"),
    [
        ({"servo_delay": {"delay": 0.007}, "servo_bandwidth": {"relative": 0.1}}, PAIR, of_the_servos),
        (
            {
                "tension_error": {"factor": 1.7},
                "backlash": {"half_width": arms.on(1, 4e-4) + arms.on(4, 6e-4)},
            },
            TRUNK,
            of_the_wires,
        ),
        (
            {"sensor_delay": {"delay": 0.004}, "backlash": {"half_width": np.full(5, 4e-4)}},
            TRUNK,
            of_the_wires,
        ),
    ],
    ids=["servo_delay+servo_bandwidth", "tension_error+backlash", "sensor_delay+backlash"],
)
def test_effects_that_hide_each_other_are_both_named(
    effects: dict[str, dict[str, Any]], nominal: Model, seen: Callable[[Recording], Recording]
) -> None:
    """A later and a faster servo all but cancel; a tension and dead bands widen the same loops; a dead band
    that is narrower in fast motion takes a part of a delay."""
    result = diagnose([seen(recorded(effects, 15.0, nominal=nominal))], model=nominal)
    assert {f.effect for f in result.findings} == set(effects)
    assert result.verdict == "explained"


@pytest.mark.long
def test_against_another_simulator_its_prediction_is_what_is_doubted() -> None:
    truth = {"backlash": {"half_width": on(1, 1e-3)}, "zero_offset": {"offset": on(3, 2e-3)}}
    real = of_the_wires(recorded(truth, seconds=12.0))
    theirs = simulate(real, replace(SHORT, effects={"zero_offset": {"offset": on(3, 2e-3)}}))
    result = diagnose([real], against=theirs)
    assert [(f.effect, f.joints) for f in result.findings] == [("backlash", ["joint_1"])]


def test_several_recordings_are_one_arm() -> None:
    effects = {"ratio_error": {"relative": on(2, 0.004)}}
    result = diagnose(
        [of_the_wires(run) for run in (recorded(effects, 12.0), recorded(effects, 15.0, seed=3))]
    )
    assert [(f.effect, f.joints) for f in result.findings] == [("ratio_error", ["joint_2"])]


@pytest.mark.parametrize("order", [1, -1])
def test_what_only_one_of_several_recordings_shows_is_found_in_any_order(order: int) -> None:
    """The joint meets its stop in the wide motion alone."""
    upper = np.where(on(2, 1.0) > 0, 0.11, np.inf)
    stop = {"hard_stop": {"upper": upper}}
    bags = [recorded(stop, seconds=15.0, seed=2 + k, size=s) for k, s in enumerate((0.3, 1.0))]
    result = diagnose([of_the_wires(bag) for bag in bags[::order]])
    assert [(f.effect, f.joints) for f in result.findings] == [("hard_stop", ["joint_2"])]
    assert result.findings[0].parameters["joint_2"]["upper"]["value"] == pytest.approx(0.11, abs=1e-3)


def test_what_the_model_has_already_is_no_finding_and_stays_in_it() -> None:
    believed = {"backlash": {"half_width": on(2, 8e-4)}}
    model = replace(SHORT, effects=believed)
    result = diagnose([of_the_wires(recorded(believed, 20.0))], model=model)
    assert (result.verdict, result.findings) == ("no_mismatch", [])
    assert result.model.effects["backlash"]["half_width"][1] == pytest.approx(8e-4, rel=0.03)


def test_what_the_model_has_not_is_found_beside_what_it_has() -> None:
    model = replace(SHORT, effects={"backlash": {"half_width": on(2, 8e-4)}})
    truth = {"backlash": {"half_width": on(2, 8e-4)}, "ratio_error": {"relative": on(3, 0.006)}}
    result = diagnose([of_the_wires(recorded(truth, 20.0))], model=model)
    assert [(f.effect, f.joints) for f in result.findings] == [("ratio_error", ["joint_3"])]
    assert set(result.model.effects) == {"backlash", "ratio_error"}


@pytest.mark.long
def test_a_zero_that_is_off_and_jumps_is_named_as_both() -> None:
    """Creep over minutes explains more of it than either alone."""
    hidden = {
        "zero_offset": {"offset": on(1, -4.5e-4)},
        "wire_slip": {"step": on(1, 2.4e-4), "onset": np.full(3, 14.0)},
    }
    result = diagnose([of_the_wires(recorded(hidden, 20.0))])
    assert {(f.effect, *f.joints) for f in result.findings} == {
        ("zero_offset", "joint_1"),
        ("wire_slip", "joint_1"),
    }


@pytest.mark.long
def test_a_top_speed_that_one_joint_meets_is_the_servos_of_all() -> None:
    hidden = {"velocity_saturation": {"v_max": 0.45}, "servo_delay": {"delay": 0.004}}
    result = arms.diagnose([of_the_servos(arms.recorded(hidden, 40.0, size=0.9))])
    assert {f.effect: len(f.joints) for f in result.findings} == dict.fromkeys(hidden, 5)
