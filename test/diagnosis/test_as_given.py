"""What the model has stays where the recording does not tell otherwise."""

from __future__ import annotations

from dataclasses import replace

import pytest

from test.diagnosis.search.looks import context
from trunk_ros.diagnosis.evidence.as_given import as_given
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import costed


@pytest.mark.parametrize(("half_width", "stays"), [(1e-6, True), (1e-3, False)])
def test_an_effect_of_the_model_is_left_out_only_where_the_recording_tells_it(
    half_width: float, stays: bool
) -> None:
    """A dead band of 1 µrad is far below what readings show, one of 1 mrad is surely not there."""
    clean = context("clean")
    known = Hypothesis(backlash=Term("backlash", own={2: {"half_width": half_width}}))
    model = replace(clean.stage.model, effects=known.model_effects(5))
    stage = type(clean.stage)([view.span for view in clean.views], model)
    left_out = costed(replace(clean, stage=stage), Hypothesis())
    assert ("backlash" in as_given(left_out).hypothesis) == stays
