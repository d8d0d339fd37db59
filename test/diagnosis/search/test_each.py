"""Hypotheses of one pattern go through the wire together: each as it would by itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from test.diagnosis.search.looks import context
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.wire import WireStage
from trunk_ros.effects import effect, registry

COLUMN = 2
FORMULA = "distributed_wire"  # wants the wire's formula, which this arm's description does not give
FORMS = [
    (k.id, form) for k in registry().values() if k.stage == "wire" and k.id != FORMULA for form in k.forms
]


def made(name: str, form: str, times: float, source: str = "joint_2") -> Hypothesis:
    """An effect in its usual size so many times, beside a dead band."""
    kind = effect(name)
    used = kind.own_parameters(form)
    own = {p.name: times * p.typical for p in used if not p.shared}
    shared = {p.name: p.typical for p in used if p.shared and not p.optional}
    words = {COLUMN: {kind.texts[0]: source}} if kind.texts else {}
    out = Hypothesis(backlash=Term("backlash", own={COLUMN: {"half_width": times * 1e-3}}))
    out[name] = Term(name, form, shared, {COLUMN: own}, words)
    return out


@pytest.mark.parametrize(("name", "form"), FORMS)
def test_each_is_predicted_as_by_itself(name: str, form: str) -> None:
    look = context("sag")
    each = [made(name, form, times) for times in (0.9, 1.0, 1.1)]
    alone = [look.predict(0, one, COLUMN) for one in each]
    together = look.predict_each(0, each, COLUMN)
    assert all(np.array_equal(a, b) for a, b in zip(together, alone, strict=True))


def test_what_is_of_another_pattern_goes_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    look, passes = context("sag"), []
    passed = WireStage._passed

    def counted(self: Any, context: Any, index: int, hypotheses: Any, column: int) -> Any:
        passes.append(len(hypotheses))
        return passed(self, context, index, hypotheses, column)

    monkeypatch.setattr(WireStage, "_passed", counted)
    late = Hypothesis(wire_slip=Term("wire_slip", own={COLUMN: {"step": 1e-3, "onset": 9.0}}))
    each = [
        *(made("zero_offset", "", t) for t in (1.0, 2.0)),
        late,
        Hypothesis(),
        made("zero_offset", "", 3.0),
    ]
    together = look.predict_each(0, each, COLUMN)
    assert sorted(passes) == [1, 1, 3]
    alone = [look.predict(0, one, COLUMN) for one in each]
    assert all(np.array_equal(a, b) for a, b in zip(together, alone, strict=True))
