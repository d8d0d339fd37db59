"""What is part of an effect's form is told besides, where the recording shows it."""

from __future__ import annotations

from copy import copy, deepcopy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from test.diagnosis.search.looks import context, fitted
from trunk_ros.diagnosis.evidence.evidence import Evidence, evidence
from trunk_ros.diagnosis.evidence.spreads import Spreads, spreads
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.verdict.included import _told, all_findings, included, names_said
from trunk_ros.effects import effect, registry
from trunk_ros.effects.wire.link_resonance import RIGID
from trunk_ros.model import load_model


@cache
def held(arm: str, compliance: float) -> tuple[Fit, dict[str, Evidence], Spreads]:
    """Links that swing, under friction, on the wires of an arm: what is fitted, and how sure that is."""
    own = {c: {"compliance": compliance, "damping": 0.1} for c in range(5)}
    state = fitted(arm, Term("load_elasticity", "held", own=own))
    return state, evidence(state), spreads(state)


def test_links_that_swing_on_soft_wires_are_told_besides() -> None:
    state, sure, std = held("heavy upstream", 0.08)
    told = {f.effect: f for f in all_findings(state, sure, std)}
    assert set(told) == {"load_elasticity", "link_resonance"}
    found, arm = told["link_resonance"], load_model("trunk").arm
    assert "joint_1" in found.joints
    assert found.confidence > 0.8
    for joint, values in found.parameters.items():
        straight = arm.straight_inertia[arm.joints.index(joint)]
        assert values["frequency"]["value"] == pytest.approx(0.5 / np.pi / np.sqrt(0.08 * straight), rel=0.05)
    assert found.parameters["joint_1"]["damping"]["value"] == pytest.approx(0.1, rel=0.3)


def test_where_nothing_swings_nothing_is_told() -> None:
    state, sure, std = held("upstream", 0.05)
    assert not included(state, sure, std)[0]


def test_what_the_model_has_already_is_not_told_again() -> None:
    state, sure, std = held("heavy upstream", 0.08)
    stage = copy(state.context.stage)
    stage.known = state.hypothesis
    known = replace(state, context=replace(state.context, stage=stage))
    assert not included(known, sure, std)[0]
    bent = {c: {"compliance": 0.08, "damping": 0.1, "threshold": 0.1} for c in range(5)}
    stage.known = Hypothesis({"wire_slack": Term("wire_slack", "held", own=bent)})
    assert not included(known, sure, std)[0], "they swing on wires that are not slack"
    stage.known = Hypothesis({"load_elasticity": Term("load_elasticity", own={0: {"compliance": 0.05}})})
    assert included(known, sure, std)[0], "the model's wires carry nothing that swings"


def test_a_swing_that_the_model_has_by_itself_is_not_said_to_be_gone() -> None:
    state, sure, std = held("heavy upstream", 0.08)
    swing = included(state, sure, std)[0]["link_resonance"]
    stage = copy(state.context.stage)
    stage.known = Hypothesis({"link_resonance": Term("link_resonance", "links", own=swing.own)})
    known = replace(state, context=replace(state.context, stage=stage))
    told = all_findings(known, sure, std)
    assert [f.effect for f in told] == ["load_elasticity"]


def test_a_joint_that_does_not_give_way_does_not_swing() -> None:
    values = {"compliance": np.array([0.0]), "damping": np.array([0.1])}
    now = context("upstream").now(0, 0)
    assert effect("load_elasticity")(values, form="held").included(now)["frequency"] == RIGID


def test_links_swing_with_the_payload_that_was_found() -> None:
    own = {c: {"compliance": 0.08, "damping": 0.1} for c in range(5)}
    swing = Term("load_elasticity", "held", {"payload": 0.1}, own)
    state = costed(context("heavy upstream"), Hypothesis({"load_elasticity": swing}))
    loaded = replace(load_model("trunk").arm, payload=0.1).straight_inertia
    for column, values in _told(state, swing, "link_resonance").own.items():
        assert values["frequency"] == pytest.approx(0.5 / np.pi / np.sqrt(0.08 * loaded[column]))


def test_effects_include_effects_that_there_are() -> None:
    for kind in registry().values():
        assert set(kind.includes) <= set(kind.forms)
        for part in kind.includes.values():
            assert effect(part).stage == kind.stage


def test_what_differs_only_in_all_its_values_together_is_told_by_that_which_differs_most() -> None:
    """A payload and compliances for which each other stand: none of them alone is surely another one."""
    state = held("heavy upstream", 0.08)[0]
    state = replace(state, hypothesis=deepcopy(state.hypothesis))
    state.hypothesis["load_elasticity"].shared["payload"] = 0.1
    sure = evidence(state)
    stage = copy(state.context.stage)
    own = {c: {"compliance": 0.075} for c in range(5)}
    stage.known = Hypothesis({"load_elasticity": Term("load_elasticity", "weight", own=own)})
    known = replace(state, context=replace(state.context, stage=stage))
    wide = {("load_elasticity", "compliance", c): 0.02 for c in range(5)}
    std = spreads(state) | wide | {("load_elasticity", "payload", None): 0.06}
    told = {f.effect: f for f in all_findings(known, sure, std)}
    assert {j: [*v] for j, v in told["load_elasticity"].parameters.items()} == {"arm": ["payload"]}
    assert told["load_elasticity"].confidence == 0.5
    stage.known = state.hypothesis.copy()
    assert not all_findings(known, sure, std)


def test_an_effect_is_in_the_model_as_found_where_only_a_part_of_its_form_is_told() -> None:
    state, sure, std = held("heavy upstream", 0.08)
    swing = [f for f in all_findings(state, sure, std) if f.effect == "link_resonance"]
    assert names_said(state.hypothesis, swing) == {"link_resonance", "load_elasticity"}
    assert names_said(state.hypothesis, []) == set()
