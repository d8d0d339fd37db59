"""Correlations of fitted values, and values at a bound: from the fit's own normal matrix."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, of_the_wires, on, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.evidence.determined import AtBound, Determined, Place, correlation, determined
from trunk_ros.diagnosis.evidence.evidence import UNNAMED
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import costed, refit
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.verdict.findings import believable
from trunk_ros.effects import effect
from trunk_ros.model import load_model


def test_two_values_are_correlated_as_their_columns_are_against_each_other() -> None:
    jacobian = np.random.default_rng(0).standard_normal((50, 2)) @ np.array([[1.0, 0.9], [0.0, 0.3]])
    a, b = (column / np.linalg.norm(column) for column in jacobian.T)
    assert correlation(jacobian.T @ jacobian)[0, 1] == pytest.approx(-float(a @ b), abs=1e-9)


def test_correlations_are_those_of_repeated_fits() -> None:
    rng = np.random.default_rng(1)
    jacobian = rng.standard_normal((40, 3)) @ rng.standard_normal((3, 3))
    noise = rng.standard_normal((40, 4000))
    found = np.corrcoef(np.linalg.lstsq(jacobian, noise, rcond=None)[0])
    assert np.abs(correlation(jacobian.T @ jacobian) - found).max() < 0.06


def test_the_scale_of_a_value_does_not_matter_and_one_that_is_not_seen_is_not_judged() -> None:
    jacobian = np.random.default_rng(2).standard_normal((30, 3))
    jacobian[:, 2] = 0.0
    scaled = jacobian * np.array([1e-6, 1e4, 1.0])
    here, there = (correlation(j.T @ j) for j in (jacobian, scaled))
    assert here[:2, :2] == pytest.approx(there[:2, :2])
    assert np.isnan(here[2]).all()


def told(hidden: float, start: float) -> tuple[Determined, str]:
    """Of a fit of a ratio error to a joint whose ratio is off by ``hidden``; the bound is 100."""
    made = recorded({"ratio_error": {"relative": on(2, hidden)}}, 20.0)
    model = load_model("trunk").for_joints(made.joints)
    context = first_look(WireStage([wire_span(made, model)], model, made.units))
    term = Term("ratio_error", own={1: {"relative": start}})
    return determined(refit(context, Hypothesis({"ratio_error": term}))), context.joints[1]


def test_a_value_that_the_data_push_against_its_bound_is_said_to_be_there() -> None:
    beyond, joint = told(hidden=103.0, start=99.0)
    assert beyond.at_bound == [AtBound(Place("ratio_error", "relative", joint), "upper", 100.0, "1")]
    inside, _ = told(hidden=97.0, start=99.0)
    assert inside.at_bound == []


@pytest.mark.parametrize("until", [9.9, 10.1])
def test_a_moment_within_the_recording_is_at_no_bound_though_it_may_be_any_of_a_million_seconds(
    until: float,
) -> None:
    """A page had said of an end at 43 s that the data ask for more than its bound, 0 s."""
    made = recorded({"ratio_error": {"relative": on(2, 0.02), "until": on(2, 10.0)}}, 20.0)
    model = load_model("trunk").for_joints(made.joints)
    context = first_look(WireStage([wire_span(made, model)], model, made.units))
    term = Term("ratio_error", own={1: {"relative": 0.02, "until": until}})
    assert determined(costed(context, Hypothesis({"ratio_error": term}))).at_bound == []


@pytest.mark.parametrize(
    ("parameter", "joints", "sure"),
    [
        ("threshold", ("elbow", "wrist"), UNNAMED),
        ("threshold", ("wrist",), 1.0),
        ("softness", ("elbow", "wrist"), 1.0),
    ],
)
def test_an_effect_whose_size_is_at_its_bound_wherever_it_is_is_no_surer_than_one_without_a_name(
    parameter: str, joints: tuple[str, ...], sure: float
) -> None:
    """A loop with feedforward had come out as one ten times as fast, the bound, at 0.95."""
    term = Term("wire_slack", "smooth", own={1: {"threshold": 1e-3}, 2: {"threshold": 1e-3}})
    at_bound = [AtBound(Place("wire_slack", parameter, joint), "lower", 1e-3, "N*m") for joint in joints]
    arm = ("shoulder", "elbow", "wrist")
    assert believable(effect("wire_slack"), term, arm, Determined([], at_bound)) == sure


def test_a_size_that_all_joints_share_has_one_bound() -> None:
    term = Term("servo_bandwidth", "alike", shared={"relative": 9.0}, own={0: {}, 1: {}})
    at_bound = [AtBound(Place("servo_bandwidth", "relative", "arm"), "upper", 9.0, "1")]
    assert believable(effect("servo_bandwidth"), term, ("a", "b"), Determined([], at_bound)) == UNNAMED
    assert believable(effect("servo_bandwidth"), term, ("a", "b"), Determined()) == 1.0


def test_a_diagnosis_says_both_of_each_finding() -> None:
    (finding,) = diagnose(of_the_wires(recorded({"ratio_error": {"relative": on(2, 0.02)}}, 10.0))).findings
    assert finding.evidence["at_bound"] == []
    assert all(abs(one["value"]) >= 0.9 for one in finding.evidence["correlations"])
