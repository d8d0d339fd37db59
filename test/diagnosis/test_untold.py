"""What one joint does not tell is as on the joint that tells it best."""

from __future__ import annotations

import pytest

from test.diagnosis.search.looks import context, fitted
from trunk_ros.diagnosis.evidence.untold import as_the_surest
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import costed

FILM = "stribeck_friction"


def test_a_value_that_changes_nothing_is_the_other_joints() -> None:
    tells, hardly = (
        {"amplitude": a, "velocity": v, "memory": m} for a, v, m in ((1e-6, 0.03, 0.15), (1e-9, 0.02, 0.9))
    )
    state = costed(context("clean"), Hypothesis({FILM: Term(FILM, "film", own={1: tells, 3: hardly})}))
    assert as_the_surest(state, {}) is state
    sure = as_the_surest(state, {(FILM, "memory", 3): 2.0}).hypothesis[FILM].own
    assert sure[1] == tells
    assert (sure[3]["velocity"], sure[3]["memory"]) == pytest.approx((0.03, 0.15), rel=0.1)


def test_a_value_that_the_joint_tells_stays_whatever_its_spread() -> None:
    own = {c: {"amplitude": a, "velocity": 0.03, "memory": 0.15} for c, a in ((1, 4e-3), (3, 3e-3))}
    state = fitted("oiled on two", Term(FILM, "film", own=own))
    sure = as_the_surest(state, {(FILM, "amplitude", 3): 1.0}).hypothesis[FILM].own
    assert sure[3]["amplitude"] == pytest.approx(3e-3, rel=0.05)
