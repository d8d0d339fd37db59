"""A name is no surer than what is left of blocks that the fit has not seen lets it be."""

from __future__ import annotations

from dataclasses import replace

import pytest

from test.diagnosis.search.looks import context
from trunk_ros.diagnosis.evidence.cross_validation import Error, held_out
from trunk_ros.diagnosis.evidence.evidence import Evidence, as_unseen
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.formed import measured

WIDE = Term("backlash", own={2: {"half_width": 1.5e-3}})


@pytest.fixture(scope="module")
def fitted() -> Fit:
    return refit(context("backlash"), Hypothesis(backlash=WIDE))


def found_by(fitted: Fit) -> dict[str, Evidence]:
    nothing = fitted.context.whitened(Hypothesis(), 2)
    gain = float(nothing @ nothing) - fitted.cost[2]
    return {"backlash": Evidence({2: gain}, 60.0, 10.0, confidence=0.9)}


def test_what_holds_on_blocks_not_seen_is_as_sure_as_before(fitted: Fit) -> None:
    found = found_by(fitted)
    assert as_unseen(fitted, found, held_out(fitted)) == found


def test_beside_as_much_again_that_is_not_explained_it_is_a_guess(fitted: Fit) -> None:
    found, noise = found_by(fitted), fitted.context.noise[2].std
    power = noise**2 * found["backlash"].gain[2] / fitted.context.count(2)
    sure = []
    for times in (0.1, 1.0, 10.0):
        off = Error(1.0, 0.0, (noise**2 + times * power) ** 0.5, 0.0, noise, 1.0)
        told = as_unseen(fitted, found, {2: off})["backlash"]
        assert replace(told, confidence=0.0) == replace(found["backlash"], confidence=0.0)
        sure.append(told.confidence)
    assert sure[0] == found["backlash"].confidence
    assert 0.6 > sure[1] > 0.5 > sure[2]


def test_misfits_are_in_the_noise_of_now(fitted: Fit) -> None:
    """Whatever the noise was taken for when they were measured."""
    now = measured(refit(context("backlash"), Hypothesis()))
    louder = now.in_noise([replace(n, std=10.0 * n.std) for n in now.noise])
    assert louder.misfit[2] == pytest.approx(now.misfit[2] / 100.0)
    assert louder.formed_misfit[2] == pytest.approx(now.formed_misfit[2] / 100.0)
    again = louder.weighed(Hypothesis(backlash=fitted.hypothesis["backlash"]))
    assert again.misfit[2] == pytest.approx(now.misfit[2] * (now.noise[2].std / again.noise[2].std) ** 2)
