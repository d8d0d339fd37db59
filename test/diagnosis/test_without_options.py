"""On which side of its friction a wire gives way, where the recording hardly tells."""

from __future__ import annotations

from functools import cache

import pytest

from test.diagnosis.arms import SHORT, recorded
from test.diagnosis.test_one_arm import context
from trunk_ros.diagnosis.evidence.evidence import Evidence, one_evidence
from trunk_ros.diagnosis.evidence.spreads import spreads
from trunk_ros.diagnosis.evidence.without_options import with_likelier_options
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.verdict.included import all_findings

SOFT = 0.05


@cache
def sagging(upstream: float, noise: float) -> tuple[Fit, Evidence]:
    """An arm on soft wires, fitted as if these gave way behind their friction."""
    effects = {"load_elasticity": {"compliance": SOFT, "upstream": upstream}}
    own = {c: {"compliance": SOFT} for c in range(3)}
    seen = context(recorded(effects, noise=noise, nominal=SHORT))
    state = refit(seen, Hypothesis({"load_elasticity": Term("load_elasticity", "weight", own=own)}))
    return state, one_evidence(state, "load_elasticity")


def statement(state: Fit, found: Evidence) -> str:
    (told,) = all_findings(state, {"load_elasticity": found}, spreads(state))
    assert told.evidence["untold"] == [o for o in found.untold if o not in told.parameters.get("arm", {})]
    return told.statement


@pytest.mark.parametrize("upstream", [0.0, 1.0])
def test_what_noise_hides_is_said(upstream: float) -> None:
    state, found = sagging(upstream, 5e-3)
    assert found.untold == ["upstream"]
    assert "these data do not tell" in statement(state, found)


def test_what_the_recording_tells_is_not_called_untold() -> None:
    state, found = sagging(0.0, 2e-5)
    assert not found.untold
    assert "do not tell" not in statement(state, found)


def test_the_model_has_the_side_that_the_recording_hints_at() -> None:
    for upstream in (0.0, 1.0):
        state, found = sagging(upstream, 2e-4)
        assert found.untold == ["upstream"]
        best = with_likelier_options(state, {"load_elasticity": found.untold})
        shared = best.hypothesis["load_elasticity"].shared
        assert shared.get("upstream", 0.0) == pytest.approx(upstream, abs=0.3)
        assert ("do not tell" in statement(best, found)) == (not shared)  # else its spread tells
