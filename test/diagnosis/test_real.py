"""A real wrist, where its recordings lie beside the project: a model found on one run predicts others."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.real import QUASI_STATIC, diagnosed, marks, named, read
from trunk_ros.diagnosis import Diagnosis
from trunk_ros.simulate import simulate

WRIST = "dvrk-wrist"
COUPLED = ("q5", "q6")
LINEAR = {"exp1": (0.121, 0.122), "exp2": (0.099, 0.103), "exp4": (0.141, 0.074)}
"""rms [rad] of q5 and q6 under a linear map of all six commands, fitted on the first 70 % of train_random."""

pytestmark = [*marks(WRIST), pytest.mark.long]


@pytest.fixture(scope="module")
def result() -> Diagnosis:
    """From a part of the run that docs/real.md takes 70 % of: it shows the cross-talk as well."""
    return diagnosed(WRIST, "train_random", WRIST, until="12%", joints=COUPLED)


def rms(result: Diagnosis, name: str) -> np.ndarray:
    run = read(WRIST, name, WRIST, COUPLED)
    predicted = simulate(run, result.model).series["joint_states"]
    error = predicted.position - run.series["joint_states"].select(predicted.joints).position
    return np.asarray(np.sqrt(np.nanmean(error**2, axis=0)))


@pytest.mark.parametrize("name", sorted(LINEAR))
def test_the_model_found_predicts_the_wrist_better_than_a_linear_map(result: Diagnosis, name: str) -> None:
    assert np.all(rms(result, name) < LINEAR[name])


def test_the_cross_talk_of_q5_and_q6_is_named(result: Diagnosis) -> None:
    (coupling,) = [f for f in result.findings if f.effect == "joint_coupling"]
    assert {"q5", "q6"} <= set(coupling.joints)
    assert coupling.parameters["q5"]["source"]["value"] == "q6"
    assert coupling.parameters["q6"]["source"]["value"] == "q5"


def test_a_recording_that_stops_to_measure_shows_nothing_of_speed(result: Diagnosis) -> None:
    assert not QUASI_STATIC & named(result)
    assert "high_speed" not in {f.regime for f in result.findings}
