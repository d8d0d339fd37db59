"""What the model has stays where the recording does not tell otherwise."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import TRUNK, of_the_wires, recorded
from test.diagnosis.search.looks import context, knowing
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.discrepancy.curves import curves_beside
from trunk_ros.diagnosis.evidence.as_given import as_given
from trunk_ros.diagnosis.evidence.evidence import banks_evidence
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.moves.form import _starts
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.curve import VALUES
from trunk_ros.effects.moments import NOTHING


@pytest.mark.parametrize(("half_width", "stays"), [(1e-6, True), (1e-3, False)])
def test_an_effect_of_the_model_is_left_out_only_where_the_recording_tells_it(
    half_width: float, stays: bool
) -> None:
    """A dead band of 1 µrad is far below what readings show, one of 1 mrad is surely not there."""
    clean = context("clean")
    known = Hypothesis(backlash=Term("backlash", own={2: {"half_width": half_width}}))
    left_out = costed(knowing(clean, known), Hypothesis())
    assert ("backlash" in as_given(left_out).hypothesis) == stays


def test_values_of_the_model_beside_which_something_is_incredible_are_not_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known = Hypothesis(backlash=Term("backlash", own={2: {"half_width": 1e-6}}))
    left_out = costed(knowing(context("clean"), known), Hypothesis())
    there = sys.modules[as_given.__module__]
    monkeypatch.setattr(there, "unshown", lambda context, hypothesis: len(hypothesis))
    assert not as_given(left_out).hypothesis


def test_an_effect_of_the_model_stays_where_a_curve_stands_for_it() -> None:
    soft = {"load_elasticity": {"compliance": np.full(5, 0.03)}}
    model, made = replace(TRUNK, effects=soft), of_the_wires(recorded(soft, 40.0))
    now = begun(first_look(WireStage([wire_span(made, model)], model))).context
    bare = now.known.without("load_elasticity", 1)
    over_load = next(
        drawn for drawn in curves_beside(now, bare, 1) if drawn["unknown"].words[1] == {"on": "load"}
    )
    given = as_given(costed(now, over_load)).hypothesis
    assert given["load_elasticity"].own == now.known["load_elasticity"].own


def test_a_joint_that_never_bears_the_load_at_which_a_law_bends_has_what_the_model_has() -> None:
    soft = {"load_elasticity": {"compliance": np.full(5, 0.03)}}
    model, made = replace(TRUNK, effects=soft), of_the_wires(recorded(soft, 40.0))
    now = begun(first_look(WireStage([wire_span(made, model)], model))).context
    own = {c: {"threshold": 0.1 if c else 1e-3, "compliance": 0.03} for c in range(5)}
    bends = costed(now, Hypothesis(wire_slack=Term("wire_slack", "sharp", own=own)))
    load = [max(np.abs(v.load_of(c, NOTHING)).max() for v in now.views) for c in range(5)]
    given = as_given(bends).hypothesis
    beyond = [c for c in range(5) if load[c] < 0.1]
    assert beyond
    assert set(beyond) <= set(given["load_elasticity"].columns)
    assert all(given["load_elasticity"].own[c] == now.known["load_elasticity"].own[c] for c in beyond)


def test_a_fuller_law_on_one_joint_takes_nothing_of_the_model_from_the_others() -> None:
    """That the others do not stretch would be a claim; here they do, as the model has it."""
    soft = {"load_elasticity": {"compliance": np.full(5, 0.03)}}
    own = {"compliance": np.array([0.03, 0.0, 0.03, 0.03, 0.03])}
    hard = {"compliance": np.array([0.0, 0.03, 0.0, 0.0, 0.0]), "moment": np.full(5, 0.05), "form": "tangent"}
    made = of_the_wires(recorded({"load_elasticity": own, "wire_stiffening": hard}, 40.0))
    model = replace(TRUNK, effects=soft)
    now = begun(first_look(WireStage([wire_span(made, model)], model))).context
    hardens = Term("wire_stiffening", "tangent", {"upstream": 0.0}, {1: {"moment": 0.05, "compliance": 0.03}})
    given = as_given(costed(now, Hypothesis(wire_stiffening=hardens))).hypothesis
    assert given["load_elasticity"].columns == [0, 2, 3, 4]
    assert all(own == now.known["load_elasticity"].own[c] for c, own in given["load_elasticity"].own.items())


def at_rest(effects: dict[str, dict[str, Any]]) -> Fit:
    """A model with some effects, as it is, of whose arm the fifth joint rests."""
    model = replace(TRUNK, effects=effects)
    made = of_the_wires(recorded(effects, 30.0, size=np.array([1.0, 1.0, 1.0, 1.0, 0.0])))
    return begun(first_look(WireStage([wire_span(made, model)], model)))


def test_a_curve_of_the_model_on_a_joint_that_rests_is_judged_by_the_others() -> None:
    heights = {p.name: np.full(5, 2e-3 * np.sin(2.0 * k)) for k, p in enumerate(VALUES)}
    ends = {"low": np.full(5, -0.5), "high": np.full(5, 0.5), "on": ["position"] * 5}
    now = at_rest({"unknown": {**ends, **heights}})
    assert now.context.columns == [0, 1, 2, 3]
    assert banks_evidence(now, {})["unknown"].gain.keys() == {0, 1, 2, 3}


def test_a_joint_that_rests_keeps_no_other_from_a_further_form() -> None:
    creep = {"viscoelastic_creep": {"form": "one_mode", "gain": np.full(5, 0.02), "time_constant": 4.0}}
    now = at_rest(creep)
    for start in _starts(now, "viscoelastic_creep", "two_modes"):
        assert start["viscoelastic_creep"].own.keys() == {0, 1, 2, 3, 4}
        assert start["viscoelastic_creep"].own[4]["gain"] == 0.02
    assert _starts(now, "viscoelastic_creep", "two_modes")
