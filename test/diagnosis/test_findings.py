"""Findings in the words and units of the recording."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose, of_the_wires, recorded, reshaped
from trunk_ros.diagnosis.hypothesis import Term
from trunk_ros.diagnosis.verdict.findings import _parameters, settled, statement_of, value_of
from trunk_ros.effects import effect


def test_a_curve_over_a_sliding_joint_is_in_metres() -> None:
    recording = of_the_wires(recorded(seconds=20.0, nominal=SHORT))
    position = recording.series["joint_states"].position.copy()
    position[:, 2] += 1e-3 * np.exp(-0.5 * ((position[:, 2] - 0.05) / 0.05) ** 2)
    recording = reshaped(recording, "joint_states", position=position)
    (found,) = diagnose([replace(recording, units={"joint_3": "m"})], SHORT).findings
    assert (found.effect, found.depends_on) == ("unknown", ["position"])
    assert (found.curve["x_unit"], found.curve["y_unit"]) == ("m", "m")


@pytest.mark.parametrize(("spread", "sure"), [(0.002, 1.0), (2e8, 0.5)])
def test_a_size_that_the_data_do_not_tell_is_not_sure_beside_what_a_description_states(
    spread: float, sure: float
) -> None:
    """A wire of a stated compliance, that hardens at a moment known to so much."""
    kind = effect("wire_stiffening")
    term = Term(
        kind.id, "tangent", {}, {0: {"moment": 0.1, "compliance": 0.03}}, given=frozenset({"compliance"})
    )
    assert settled(kind, term, {(kind.id, "moment", 0): spread}) == sure


@pytest.mark.parametrize(("stated", "sure"), [("compliance", 1.0), ("damping", 0.5)])
def test_only_beside_what_a_description_states_a_size_may_be_near_its_spread(
    stated: str, sure: float
) -> None:
    """Also what a model has and what a curve is drawn over is not fitted."""
    kind = effect("wire_stiffening")
    term = Term(kind.id, "tangent", {}, {0: {"moment": 0.1}}, given=frozenset({stated}))
    assert settled(kind, term, {(kind.id, "moment", 0): 0.05}) == sure


def test_a_value_that_was_held_is_said_without_a_spread() -> None:
    """As that of a part of a form whose values the model has."""
    told = {
        name: value_of(79.73, std, "Hz") for name, std in {"held": 0.0, "hidden": None, "seen": 2.0}.items()
    }
    said = "joint_1 held = 79.7 Hz; joint_1 hidden = 79.7 Hz; joint_1 seen = 79.7 ± 2 Hz"
    assert statement_of("Links swing", "joint_1", {"joint_1": told}) == f"joint_1: links swing ({said})."


def test_a_value_as_uncertain_as_it_is_large_is_not_said() -> None:
    """A wire that hardens on one joint at a moment, on the other past all that it bore."""
    kind, context = (
        effect("wire_stiffening"),
        SimpleNamespace(joints=("a", "b"), stage=SimpleNamespace(unit=lambda _: "rad")),
    )
    own = {0: {"moment": 0.1, "compliance": 0.03}, 1: {"moment": 700.0, "compliance": 0.03}}
    spread = {(kind.id, "moment", 0): 0.002, (kind.id, "moment", 1): 1e12, (kind.id, "compliance", 1): 1e-4}
    told = _parameters(cast(Any, context), kind, Term(kind.id, "smooth", {}, own), spread)
    assert (told["a"].keys(), told["b"].keys()) == ({"moment", "compliance"}, {"compliance"})
