"""What was found on a joint stays only where all of it together is no worse than nothing; what has no name
only where it is better.
"""

from __future__ import annotations

import pytest

from test.diagnosis.search.looks import context
from trunk_ros.diagnosis.evidence import no_worse as judged
from trunk_ros.diagnosis.evidence.cross_validation import Error
from trunk_ros.diagnosis.evidence.no_worse import no_worse
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, costed


def found() -> Fit:
    """A dead band that is there on joint 3, and one on joint 4."""
    wide = Term("backlash", own={2: {"half_width": 1.5e-3}, 3: {"half_width": 1e-4}})
    return costed(context("backlash"), Hypothesis(backlash=wide))


def test_what_helps_stays() -> None:
    state, errors = no_worse(found())
    assert state.hypothesis["backlash"].columns == [2, 3]
    assert errors[2].after < 0.5 * errors[2].before


def worse(monkeypatch: pytest.MonkeyPatch, after: float, usual: float = 1.0) -> None:
    """Let joint 4 be off by so much [rad] with what is found on it, and by 1 mrad without."""

    def said(state: Fit) -> dict[int, Error]:
        there = {c for term in state.hypothesis.values() for c in term.columns}
        off = Error(1e-3, 1e-4, after, 1e-4, 1e-4, usual)
        better = Error(1e-3, 1e-4, 2e-4, 1e-5, 1e-4, 2e-4)
        return {c: off if c == 3 and c in there else better for c in state.context.columns}

    monkeypatch.setattr(judged, "held_out", said)


@pytest.mark.parametrize(
    ("after", "usual", "kept"), [(1.05e-3, 1.0, [2, 3]), (2e-3, 9e-4, [2, 3]), (2e-3, 1.8e-3, [2])]
)
def test_a_joint_that_is_surely_and_usually_worse_off_loses_what_was_found_on_it(
    monkeypatch: pytest.MonkeyPatch, after: float, usual: float, kept: list[int]
) -> None:
    worse(monkeypatch, after, usual)
    state, errors = no_worse(found())
    assert state.hypothesis["backlash"].columns == kept
    assert (errors[3].after <= 1e-3) == (kept == [2])


@pytest.mark.parametrize(("after", "kept"), [(9e-4, [3]), (1.05e-3, [])])
def test_what_has_no_name_goes_where_it_is_no_better(
    monkeypatch: pytest.MonkeyPatch, after: float, kept: list[int]
) -> None:
    worse(monkeypatch, after)
    said, wide = found(), {"half_width": 1.5e-3}
    curve = Term("unknown", own={3: {"low": -0.3, "high": 0.3}}, words={3: {"on": "position"}})
    both = Hypothesis(backlash=Term("backlash", own={2: wide, 3: wide}), unknown=curve)
    state, _ = no_worse(costed(said.context, both))
    assert [
        c for c in (3,) if "unknown" in state.hypothesis and c in state.hypothesis["unknown"].columns
    ] == kept
    assert state.hypothesis["backlash"].columns == [2, 3]


def test_what_the_model_has_is_not_taken_from_it(monkeypatch: pytest.MonkeyPatch) -> None:
    worse(monkeypatch, 2e-3)
    said = found()
    said.context.stage.known["backlash"] = said.hypothesis["backlash"]
    try:
        assert no_worse(said)[0].hypothesis["backlash"].columns == [2, 3]
    finally:
        del said.context.stage.known["backlash"]
