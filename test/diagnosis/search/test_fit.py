"""Fits: as exact as the data allow, and no look more than that takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.search.looks import context
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term, bounds
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.fit import Fit, fit, refit
from trunk_ros.diagnosis.search.residuals import Residuals


def predictions(look: Context, hypothesis: Hypothesis, column: int) -> tuple[Fit, float]:
    """The fit of one joint, and how many predictions it took."""
    counted = replace(look, work=Work())
    done = fit(counted, hypothesis, [column])
    return done, counted.work.done / len(look.views[0].span.grid)


def test_what_is_linear_takes_two_steps() -> None:
    look = context("clean")
    shifted = Hypothesis(zero_offset=Term("zero_offset", own={2: {"offset": 0.02}}))
    done, took = predictions(look, shifted, 2)
    assert took == 5  # where it begins, two slopes, where they lead; the first step is damped
    best = np.mean(look.whitened(Hypothesis(), 2)) * look.noise[2].std
    assert done.hypothesis["zero_offset"].own[2]["offset"] == pytest.approx(best, abs=1e-6)


def test_what_bends_is_followed_until_nothing_is_left_to_gain() -> None:
    look = context("backlash")
    wide = Hypothesis(backlash=Term("backlash", own={2: {"half_width": 6e-3}}))
    done, took = predictions(look, wide, 2)
    assert took > 5
    there = Residuals(look, done.hypothesis, [2])
    slope, normal = there.normal(done.hypothesis.free_values(there.free))
    assert slope[0] ** 2 / normal[0, 0] < 0.1  # of squared unit noise
    assert done.hypothesis["backlash"].own[2]["half_width"] == pytest.approx(1.5e-3, abs=5e-5)


def test_a_phase_goes_beyond_any_bound_and_stays_the_same_phase() -> None:
    swing = {"amplitude": 1e-3, "cycles_per_rev": 4.0, "phase": 0.5}
    rippled = Hypothesis(transmission_ripple=Term("transmission_ripple", "sine", own={2: dict(swing)}))
    free = [f for f in rippled.free([2]) if f.parameter.name == "phase"]
    assert [float(bound[0]) for bound in bounds(free)] == [-np.inf, np.inf]
    turned = rippled.put(free, np.array([0.5 + 20.0 * np.pi]))
    assert turned["transmission_ripple"].own[2]["phase"] == pytest.approx(0.5)


def test_an_order_is_fitted_beside_the_phase_in_the_middle_of_the_motion() -> None:
    """What it does then is the same as with the phase at angle 0, seen along other values."""
    look = context("clean")
    swing = {"amplitude": 1e-3, "cycles_per_rev": 4.0, "phase": 0.5}
    rippled = Hypothesis(transmission_ripple=Term("transmission_ripple", "sine", own={2: swing}))
    there = Residuals(look, rippled, [2])
    x = there.hypothesis.free_values(there.free)
    assert there.turn is not None
    (_, plain), (slope, normal) = there.normal(x), there.normal_about(x)
    assert normal == pytest.approx(there.turn.T @ plain @ there.turn, rel=1e-6)
    assert there.about(there.turned(slope)) == pytest.approx(slope)


def test_a_fit_does_not_change_what_it_began_with() -> None:
    wide = Hypothesis(backlash=Term("backlash", own={2: {"half_width": 6e-3}}))
    fit(context("backlash"), wide, [2])
    assert wide["backlash"].own[2]["half_width"] == 6e-3


def test_a_shared_value_of_joints_that_are_not_judged_is_not_fitted_with_others() -> None:
    creep = Term(
        "viscoelastic_creep", own={3: {"gain": 0.01}, 4: {"gain": 0.02}}, shared={"time_constant": 5.0}
    )
    crept = Hypothesis(viscoelastic_creep=creep)
    assert crept.free([2], [2]) == []
    assert [f.column for f in crept.free([3], [2, 3])] == [3, None]
    assert [f.column for f in crept.free([3], [3, 4])] == [3]


def slackened(goal: float, spared: int = 0) -> tuple[Fit, int]:
    """Wires that go slack with a value that all joints share, refitted; and the joint-steps that it took."""
    look = replace(context("slack"), work=Work())
    own = {c: {"compliance": 0.01, "threshold": 0.1} for c in look.columns}
    slack = Term("wire_slack", own=own, shared={"upstream": 0.3})
    return refit(look, Hypothesis(wire_slack=slack), goal, spared), look.work.done


def test_what_will_not_come_to_its_goal_is_given_up() -> None:
    (whole, took), (_, less) = slackened(np.inf), slackened(0.0)
    (same, as_much) = slackened(1.01 * whole.total)
    assert less < 0.75 * took
    assert (same.total, as_much) == (whole.total, took)


def test_what_is_left_on_few_joints_may_be_spared() -> None:
    """Something else may explain it: all but one of them come down to the goal."""
    (whole, took), noise = slackened(np.inf), context("slack").least_noise
    goal = whole.total - max(cost - noise(c) for c, cost in whole.cost.items())
    assert slackened(1.01 * goal)[1] < took
    assert slackened(1.01 * goal, spared=1)[1] == took


def test_a_goal_that_others_have_used_up_is_missed_by_a_joint_of_its_own() -> None:
    look = context("backlash")
    wide = Hypothesis(backlash=Term("backlash", own={c: {"half_width": 6e-3} for c in look.columns}))
    works = [Work(), Work()]
    for work, goal in zip(works, (np.inf, 1.0), strict=True):
        refit(replace(look, work=work), wide, goal)
    assert works[1].done < works[0].done
