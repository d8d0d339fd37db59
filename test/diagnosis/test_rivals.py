"""A rival is judged by all that it predicts: where it moves a joint, what that joint pulls at moves too."""

from __future__ import annotations

from typing import Any

import pytest

from test.diagnosis.arms import on, recorded
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.align import wire_span
from trunk_ros.diagnosis.evidence.evidence import Evidence, one_evidence
from trunk_ros.diagnosis.hypothesis import hypothesis_of
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.wire import WireStage
from trunk_ros.model import load_model

LATE = {"sensor_delay": {"delay": 0.02}}
COUPLED = {"joint_coupling": {"gain": on(5, 0.1), "source": ["", "", "", "", "joint_2"]}}


def judged(effects: dict[str, dict[str, Any]]) -> Evidence:
    """Evidence for the late sensor in a recording of these effects, found as they are."""
    nominal = load_model("trunk")
    stage = WireStage([wire_span(recorded(effects, 20.0), nominal)], nominal)
    truth = hypothesis_of(effects, "wire", len(stage.joints))
    context = Context.of(stage).seen_with(truth).weighed(truth)
    return one_evidence(refit(context, truth), "sensor_delay")


def test_a_lag_of_all_joints_is_a_late_sensor_where_none_pulls_at_another() -> None:
    assert judged(LATE).equivalents == ["viscous_lag"]


def test_a_joint_that_lags_pulls_late_where_a_sensor_that_is_late_does_not() -> None:
    found = judged({**LATE, **COUPLED})
    assert found.equivalents == []
    assert found.rivals["viscous_lag"] > 1000.0
    assert found.confidence == pytest.approx(0.95)
