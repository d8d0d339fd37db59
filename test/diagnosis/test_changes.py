"""A model that has effects: what the arm no longer shows of them and what changed is said, no more."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import on, recorded
from trunk_ros.diagnosis import Diagnosis, diagnose
from trunk_ros.diagnosis.report.page import render
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model

SLACK = {"backlash": {"half_width": on(3, 3e-3)}}
STRETCH = {"ratio_error": {"relative": on(2, 0.02)}}
SWINGS = {"link_resonance": {"frequency": np.where(on(4, 1.0) > 0, 3.0, 1e6), "form": "absolute"}}


def told(has: dict[str, Any], shows: dict[str, Any]) -> Diagnosis:
    """What is said of an arm that shows some effects to a model that has others."""
    return diagnose(recorded(shows, seconds=25.0), Model(load_model("trunk").arm, has))


@pytest.mark.parametrize(("has", "words"), [
    (SLACK, "joint_3: the model has 3 mrad, the recording shows none"),
    (STRETCH, "joint_2: the model has 0.02, the recording shows none"),
    (SWINGS, "joint_4: the model has 3 Hz, the recording shows none"),
])  # fmt: skip
def test_an_effect_of_the_model_that_the_arm_does_not_show_is_said(has: dict[str, Any], words: str) -> None:
    result = told(has, {})
    (only,) = result.findings
    assert (only.effect, only.equivalents, only.confidence) == (next(iter(has)), [], 0.95)
    assert words in only.statement
    assert (result.verdict, result.experiments) == ("explained", [])

    assert "Too much in the simulation" in render(result)


def test_what_the_model_has_and_the_arm_shows_is_no_finding() -> None:
    result = told(SLACK | STRETCH, SLACK | STRETCH)
    assert (result.verdict, result.findings) == ("no_mismatch", [])


def test_of_an_effect_that_changed_only_the_joints_that_changed_are_said() -> None:
    result = told(
        {"backlash": {"half_width": on(3, 3e-3) + on(5, 2e-3)}},
        {"backlash": {"half_width": on(3, 3e-3) + on(5, 4e-3)}},
    )
    (only,) = result.findings
    assert (only.effect, only.joints) == ("backlash", ["joint_5"])
    value = only.parameters["joint_5"]["half_width"]
    assert value["value"] == value["recording"] == pytest.approx(4e-3, abs=5e-5)
    assert value["simulation"] == 2e-3
    assert "2 mrad too little" in only.statement


def test_a_payload_that_changed_is_said_also_where_the_wires_are_as_they_were() -> None:
    soft = {"compliance": np.full(5, 0.05), "form": "weight"}
    result = told(
        {"load_elasticity": {**soft, "payload": 0.05}}, {"load_elasticity": {**soft, "payload": 0.15}}
    )
    (only,) = result.findings
    assert only.effect == "load_elasticity"
    assert only.parameters["arm"]["payload"]["value"] == pytest.approx(0.15, abs=0.01)


def test_an_effect_of_the_model_that_now_begins_in_mid_run_keeps_its_moment() -> None:
    late = {"backlash": {"half_width": on(3, 3e-3), "from": np.full(5, 12.0)}}
    (only,) = told(SLACK, late).findings
    assert only.parameters["joint_3"]["from"]["value"] == pytest.approx(12.0, abs=0.2)


def test_what_comes_new_beside_the_model_is_a_finding_as_ever() -> None:
    (only,) = told(SLACK, SLACK | STRETCH).findings
    assert (only.effect, only.joints) == ("ratio_error", ["joint_2"])


def test_a_value_that_a_form_does_not_have_is_refused() -> None:
    with pytest.raises(ModelError, match="through is no value of its form 'spread': set form to compliant"):
        Model.from_parameters(
            load_model("trunk").parameters()
            | {"effects.presliding_hysteresis.width": [1e-3], "effects.presliding_hysteresis.through": [0.5]}
        )
