"""A model that has effects: what the arm no longer shows of them and what changed is said, no more."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import SHORT, of_the_wires
from trunk_ros.diagnosis import Diagnosis, diagnose
from trunk_ros.diagnosis.report.page import render
from trunk_ros.diagnosis.whole_arm import on_the_arm
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model, save_model

on = partial(arms.on, joints=3)
recorded = partial(arms.recorded, nominal=SHORT)
SLACK = {"backlash": {"half_width": on(3, 3e-3)}}
STRETCH = {"ratio_error": {"relative": on(2, 0.02)}}
SWINGS = {"link_resonance": {"frequency": np.where(on(1, 1.0) > 0, 3.0, 1e6), "form": "absolute"}}

SECONDS = 16.0


def told(has: dict[str, Any], shows: dict[str, Any], experiments: bool = False) -> Diagnosis:
    """What is said of an arm that shows some effects to a model that has others."""
    run = of_the_wires(recorded(shows, seconds=SECONDS))
    return diagnose(run, Model(SHORT.arm, has), experiments=experiments)


@pytest.mark.parametrize(("has", "words"), [
    (SLACK, "joint_3: the model has 3 mrad, the recording shows none"),
    (STRETCH, "joint_2: the model has 0.02, the recording shows none"),
    (SWINGS, "joint_1: the model has 3 Hz, the recording shows none"),
])  # fmt: skip
def test_an_effect_of_the_model_that_the_arm_does_not_show_is_said(has: dict[str, Any], words: str) -> None:
    result = told(has, {}, experiments=True)
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
        {"backlash": {"half_width": on(3, 3e-3) + on(1, 2e-3)}},
        {"backlash": {"half_width": on(3, 3e-3) + on(1, 4e-3)}},
    )
    (only,) = result.findings
    assert (only.effect, only.joints) == ("backlash", ["joint_1"])
    value = only.parameters["joint_1"]["half_width"]
    assert value["value"] == value["recording"] == pytest.approx(4e-3, abs=5e-5)
    assert value["simulation"] == 2e-3
    assert "2 mrad too little" in only.statement


def test_a_payload_that_changed_is_said_also_where_the_wires_are_as_they_were() -> None:
    soft = {"compliance": np.full(3, 0.05), "form": "weight"}
    result = told(
        {"load_elasticity": {**soft, "payload": 0.05}}, {"load_elasticity": {**soft, "payload": 0.15}}
    )
    (only,) = result.findings
    assert only.effect == "load_elasticity"
    assert only.parameters["arm"]["payload"]["value"] == pytest.approx(0.15, abs=0.01)


@pytest.mark.long
def test_a_fuller_law_in_the_place_of_what_the_model_has_is_told_once() -> None:
    """A pair that goes slack stretches as the model has it up to there: nothing of that is gone."""
    soft = np.full(3, 0.05)
    slack = {"compliance": soft, "threshold": np.array([0.03, 0.01, 2e-3])}
    result = told({"load_elasticity": {"compliance": soft}}, {"wire_slack": slack})
    (only,) = result.findings
    assert only.effect == "wire_slack"
    other = told({"load_elasticity": {"compliance": 0.5 * soft}}, {"wire_slack": slack})
    assert {f.effect for f in other.findings} == {"wire_slack", "load_elasticity"}
    (changed,) = (f for f in other.findings if f.effect == "load_elasticity")
    assert "the model has 0.025 rad/(N*m), the recording shows 0.05 rad/(N*m)" in changed.statement


def test_a_weight_that_is_taken_up_for_a_time_is_said_also_where_the_model_has_only_the_wires() -> None:
    soft = {"compliance": np.full(3, 6e-3)}
    lifted = {"payload": 0.1, "payload_from": 4.5, "payload_until": 11.5}
    result = told({"load_elasticity": soft}, {"load_elasticity": {**soft, **lifted}})
    ((only,), (event,)) = result.findings, result.events
    assert list(only.parameters) == ["arm"]
    assert only.parameters["arm"]["payload"]["value"] == pytest.approx(0.1, rel=0.05)
    assert (event.begin, event.until) == (pytest.approx(4.5, abs=0.05), pytest.approx(11.5, abs=0.05))
    assert list(result.model.effects["load_elasticity"]["compliance"]) == [6e-3] * 3


def test_a_weight_at_the_tip_is_said_and_no_softer_wires_where_the_model_knows_them() -> None:
    soft = {"compliance": np.full(3, 6e-3)}
    result = told({"load_elasticity": soft}, {"load_elasticity": {**soft, "payload": 0.02}})
    (only,) = result.findings
    assert list(only.parameters) == ["arm"]
    assert only.parameters["arm"]["payload"]["value"] == pytest.approx(0.02, rel=0.1)


def test_what_the_recording_does_not_show_to_be_another_stays_as_the_model_has_it() -> None:
    has = {"load_elasticity": {"compliance": np.full(3, 2e-4)}, "backlash": {"half_width": on(3, 3e-3)}}
    result = told(has, has)
    assert (result.verdict, result.findings) == ("no_mismatch", [])
    assert list(result.model.effects["load_elasticity"]["compliance"]) == [2e-4] * 3
    assert list(result.model.effects["backlash"]["half_width"]) == list(on(3, 3e-3))


def test_an_effect_of_the_model_that_now_begins_in_mid_run_keeps_its_moment() -> None:
    late = {"backlash": {"half_width": on(3, 3e-3), "from": np.full(3, 8.0)}}
    (only,) = told(SLACK, late).findings
    assert only.parameters["joint_3"]["from"]["value"] == pytest.approx(8.0, abs=0.2)


def test_a_small_value_within_its_spread_is_no_finding() -> None:
    small = {"ratio_error": {"relative": on(2, 1.5e-4) + on(3, 1.5e-4)}}
    assert told(small, small).verdict == "no_mismatch"


def test_a_model_for_any_joints_is_compared_joint_by_joint() -> None:
    loose = load_model("direct").arm
    has = Model(loose, {"backlash": {"half_width": np.array([3e-3])}})
    run = of_the_wires(recorded({}, seconds=15.0))
    two = replace(run, series={key: each.select(each.joints[:2]) for key, each in run.series.items()})
    result = diagnose(two, has, experiments=False)
    assert "joint_1: the model has 3 mrad, the recording shows" in next(
        f.statement for f in result.findings if f.effect == "backlash"
    )


LATE = {"backlash": {"half_width": on(3, 3e-3), "from": on(3, 8.0)}}


def test_a_moment_of_the_model_that_is_kept_is_none_and_one_that_is_gone_or_moved_is_said(
    tmp_path: Path,
) -> None:
    save_model(Model(SHORT.arm, LATE), tmp_path / "model.yaml")
    run = of_the_wires(recorded(LATE, seconds=SECONDS))
    assert diagnose(run, tmp_path / "model.yaml", experiments=False).verdict == "no_mismatch"
    for shows in (SLACK, {"backlash": {"half_width": on(3, 3e-3), "from": on(3, 4.0)}}):
        (only,) = told(LATE, shows).findings
        assert "from: the model has 8 s" in only.statement


def test_a_coupling_that_moved_to_another_joint_is_said_with_both() -> None:
    def pulled(source: str) -> dict[str, Any]:
        return {"joint_coupling": {"gain": on(3, 0.03), "source": ["", "", source], "form": "angle"}}

    (only,) = told(pulled("joint_1"), pulled("joint_2")).findings
    assert "of joint_1 the model has 0.03, the recording shows none" in only.statement
    assert "of joint_2 the model has none, the recording shows 0.03" in only.statement


def test_sizes_are_said_in_the_units_of_their_values() -> None:
    has, shows = ({"load_dependent_friction": {"gain": on(2, g)}} for g in (0.05, 0.07))
    (only,) = told(has, shows).findings
    assert only.parameters["joint_2"]["gain"]["unit"] == "rad/(N*m)"
    assert "the model has 0.05 rad/(N*m), the recording shows 0.069" in only.statement


def test_what_is_gone_on_one_joint_is_said_beside_what_is_new_on_another() -> None:
    (only,) = told(SLACK, {"backlash": {"half_width": on(1, 2e-3), "from": on(1, 6.0)}}).findings
    assert "joint_3: the model has 3 mrad, the recording shows none" in only.statement
    assert "joint_1: the model has none, the recording shows 2 mrad" in only.statement


def test_a_payload_is_found_also_where_one_joint_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    moves = arms.setpoints_of

    def four(seconds: float, joints: int, *how: Any) -> np.ndarray:
        return np.asarray(moves(seconds, joints, *how) * (np.arange(joints) < joints - 1))

    monkeypatch.setattr(arms, "setpoints_of", four)
    soft = {"compliance": np.full(3, 0.05), "form": "weight"}
    (only,) = told(
        {"load_elasticity": {**soft, "payload": 0.05}}, {"load_elasticity": {**soft, "payload": 0.15}}
    ).findings
    assert only.effect == "load_elasticity"
    assert only.parameters["arm"]["payload"]["value"] == pytest.approx(0.15, abs=0.01)


def test_a_joint_that_was_not_recorded_keeps_what_the_model_has_of_it() -> None:
    has = {"backlash": {"half_width": on(3, 3e-3) + on(1, 2e-3)}}
    run = of_the_wires(recorded(has, seconds=SECONDS))
    some = replace(run, series={k: s.select(s.joints[1:]) for k, s in run.series.items()})
    result = diagnose(some, Model(SHORT.arm, has), experiments=False)
    assert result.verdict == "no_mismatch"
    assert result.model.effects["backlash"]["half_width"] == pytest.approx(
        has["backlash"]["half_width"], abs=1e-4
    )


def test_what_comes_new_beside_the_model_is_a_finding_as_ever() -> None:
    (only,) = told(SLACK, SLACK | STRETCH).findings
    assert (only.effect, only.joints) == ("ratio_error", ["joint_2"])


def test_a_value_that_a_form_does_not_have_is_refused() -> None:
    with pytest.raises(ModelError, match="through is no value of its form 'spread': set form to compliant"):
        Model.from_parameters(
            SHORT.parameters()
            | {"effects.presliding_hysteresis.width": [1e-3], "effects.presliding_hysteresis.through": [0.5]}
        )


def test_what_the_model_has_is_as_it_was_where_nothing_is_said_of_it() -> None:
    joints = ("lift", "bend")
    had = {"load_elasticity": {"form": "weight", "compliance": np.array([0.01, 0.02]), "upstream": 0.5}}
    fitted = {
        "load_elasticity": {"form": "held", "compliance": np.array([0.01, 0.02]), "damping": np.ones(2)}
    }
    assert on_the_arm(fitted, had, joints, joints, set()) == had
    told = on_the_arm(fitted, had, joints, joints, {"load_elasticity"})["load_elasticity"]
    assert told["form"] == "held"
    assert told["damping"].tolist() == [1.0, 1.0]


def test_a_payload_that_no_joint_gives_way_to_is_carried_on() -> None:
    carries = {"load_elasticity": {"compliance": np.zeros(5), "payload": 0.4}}
    model = replace(load_model("trunk"), effects=carries)
    seen = arms.recorded({"backlash": {"half_width": arms.on(2, 6e-4)}}, SECONDS)
    result = diagnose([of_the_wires(seen)], model=model, experiments=False)
    assert [f.effect for f in result.findings] == ["backlash"]
    assert result.model.effects["load_elasticity"]["payload"] == 0.4


def test_another_law_with_the_values_that_the_model_has_is_said() -> None:
    """A reading that is late by as much as the model's lag keeps its shape: that is no match."""
    lag = {"time_constant": np.full(3, 0.05)}
    law = {"viscous_lag": {**lag, "form": "shift"}}
    result = told({"viscous_lag": {**lag, "form": "first_order"}}, law)
    (only,) = result.findings
    assert (only.effect, result.model.effects["viscous_lag"]["form"]) == ("viscous_lag", "shift")
    assert f"{', '.join(only.joints)}: the model has the form first_order" in only.statement
    assert "the recording shows shift" in only.statement
    assert told(law, law).verdict == "no_mismatch"


def test_what_is_gone_beside_what_is_new_has_no_equivalent_where_both_were_measured() -> None:
    said = {"gain": on(3, 0.05), "source": ["", "", "joint_2"]}
    result = told({"joint_coupling": said}, {"posture_ratio": said})
    gone = next(f for f in result.findings if f.effect == "joint_coupling")
    assert {f.effect for f in result.findings} == {"joint_coupling", "posture_ratio"}
    assert gone.equivalents == []
    assert "of joint_2 the model has 0.05, the recording shows none" in gone.statement


@pytest.mark.parametrize("form", ["motors", "drag"])
def test_a_source_that_was_not_recorded_is_said(form: str) -> None:
    size = {"drag": on(3, 0.1)} if form == "drag" else {"gain": on(3, 0.1)}
    model = Model(SHORT.arm, {"joint_coupling": {"form": form, **size, "source": ["", "", "joint_2"]}})
    run = of_the_wires(recorded(seconds=6.0))
    some = replace(run, series={n: s.select(("joint_1", "joint_3")) for n, s in run.series.items()})
    with pytest.raises(ModelError, match="source of joint_3 is 'joint_2'"):
        diagnose([some], model=model)
