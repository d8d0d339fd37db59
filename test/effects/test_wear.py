"""Wear and drift with the way gone, from a recording through the model file to another motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, of_the_wires, on, recorded
from trunk_ros.effects import effect
from trunk_ros.effects.effect import Motion
from trunk_ros.effects.wire.friction_wear import FrictionWear
from trunk_ros.model import load_model, save_model
from trunk_ros.simulate import simulate

SPEED = 0.1  # rad/s
EVERY = np.ones(5)


def test_a_wide_loop_that_is_gone_through_once_shows_no_growth_of_its_dead_band() -> None:
    assert FrictionWear.forms_shown(Motion(wide_loop=True, once=True)) == ()
    assert FrictionWear.forms_shown(Motion(wide_loop=True)) == FrictionWear.forms


def test_a_wide_loop_hides_drift_with_the_distance_and_one_way_through_a_loop_ripples() -> None:
    drift, ripple = effect("thermal_drift"), effect("transmission_ripple")
    assert drift.forms_shown(Motion(wide_loop=True)) == ("exponential", "straight")
    assert ripple.forms_shown(Motion(once=True)) == ()
    assert drift.forms_shown(Motion()) == drift.forms
    assert ripple.forms_shown(Motion()) == ripple.forms


def test_a_drift_is_said_to_go_with_what_it_goes_with() -> None:
    drift = effect("thermal_drift")
    said = {form: drift.title(form) for form in drift.forms}
    assert {form for form, what in said.items() if "the distance" in what} == {"travel"}
    assert {form for form, what in said.items() if what.endswith("with time")} == {"exponential", "straight"}
    assert {form for form, what in said.items() if "heats" in what} == {"heated"}
    assert effect("backlash").title("") == effect("backlash").title()


@pytest.mark.timeout(240)
@pytest.mark.parametrize(("name", "rate"), [("friction_wear", 6e-5), ("thermal_drift", -3e-5)])
def test_what_goes_with_travel_is_named_kept_in_the_file_and_predicts_another_motion(
    name: str, rate: float, tmp_path: Path
) -> None:
    """The same joint slides on by another way: what counts is the way, not the time."""
    hidden = {name: {"form": "travel", "rate": on(2, rate), "speed": np.full(5, SPEED)}}
    result = diagnose([of_the_wires(recorded(hidden, seconds=60.0, noise=5e-5))])
    (found,) = result.findings
    assert (found.effect, found.joints) == (name, ["joint_2"])
    assert effect(name).title("travel")[1:] in found.statement
    fitted, speed = (found.parameters["joint_2"][key]["value"] for key in ("rate", "speed"))
    assert fitted / speed == pytest.approx(rate / SPEED, rel=0.01)
    save_model(result.model, tmp_path / "model.yaml")
    again = load_model(tmp_path / "model.yaml")
    assert again.parameters() == result.model.parameters()
    other = recorded(hidden, seconds=60.0, seed=5, noise=0.0)
    shown = simulate(other, again).series["joint_states"].position
    assert np.abs(shown - other.series["joint_states"].position)[600:, 1].max() < 1e-4


@pytest.mark.timeout(240)
def test_a_drift_that_the_motion_heats_is_named_and_predicts_another_motion() -> None:
    hidden = {"thermal_drift": {"form": "heated", "amplitude": on(2, 2e-3), "time_constant": 12.0 * EVERY,
                                "speed": SPEED * EVERY}}  # fmt: skip
    result = diagnose([of_the_wires(recorded(hidden, seconds=60.0, noise=5e-5))])
    (found,) = result.findings
    assert (found.effect, found.joints) == ("thermal_drift", ["joint_2"])
    assert effect("thermal_drift").title("heated")[1:] in found.statement
    fitted, speed = (found.parameters["joint_2"][key]["value"] for key in ("amplitude", "speed"))
    assert fitted / speed == pytest.approx(2e-3 / SPEED, rel=0.05)
    other = recorded(hidden, seconds=60.0, seed=5, noise=0.0)
    shown = simulate(other, result.model).series["joint_states"].position
    assert np.abs(shown - other.series["joint_states"].position)[600:, 1].max() < 1e-4
