"""The score: pure, and with a reason for every price."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import TRUNK, recorded
from test.diagnosis.search.looks import context, fitted, knowing
from trunk_ros.data.align import servo_span
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.score import (
    BETTER,
    CURVE,
    FORMULAS,
    RELEVANT,
    SIGNIFICANT,
    SLICE,
    UNSHOWN,
    beats,
    may_be_for_a_time,
    naming,
    need,
    price,
    score,
)  # fmt: skip
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.diagnosis.stages.stage import STANDING

BACKLASH = Term("backlash", own={2: {"half_width": 1.5e-3}})


def test_the_score_depends_on_nothing_but_the_fit() -> None:
    now = fitted("two", BACKLASH)
    first = score(now)
    score(fitted("clean"))
    score(replace(now, hypothesis=Hypothesis()))
    assert score(now) == first
    assert score(costed(now.context, now.hypothesis)) == pytest.approx(first, abs=1e-6)


def test_an_effect_costs_what_chance_or_relevance_ask_for() -> None:
    now = fitted("backlash", BACKLASH)
    asked = max(SIGNIFICANT, RELEVANT * now.context.count(2))
    assert need(now.context, 2) >= asked
    assert price(now, now.hypothesis["backlash"]) == pytest.approx(
        naming("wire") + need(now.context, 2, now.rest(2))
    )


def test_what_the_model_has_already_costs_nothing_and_what_it_gets_besides_does() -> None:
    now = fitted("backlash", BACKLASH)
    there = replace(now, context=knowing(now.context, now.hypothesis))
    term = now.hypothesis["backlash"]
    assert price(there, term) == 0.0
    begins = replace(term, own={2: {**term.own[2], "from": 15.0}})
    assert price(there, begins) >= need(now.context, 2)
    assert price(now, begins) >= price(now, term) + need(now.context, 2)
    lately = Term("backlash", own={c: {"half_width": 1e-3} for c in (1, 2)})
    lately.own[1]["from"] = 12.0
    there = replace(now, context=knowing(now.context, Hypothesis(backlash=lately)))
    assert "from" not in there.context.known["backlash"].own[2], "an array has a null of joints without"
    assert price(there, begins) >= need(now.context, 2)


def test_a_further_source_beside_what_the_model_has_costs_a_further_effect() -> None:
    now = fitted("clean")
    one = Term("joint_coupling", "angle", {}, {2: {"gain": 0.01}}, {2: {"source": "joint_1"}})
    there = replace(now, context=knowing(now.context, Hypothesis(joint_coupling=one)))
    two = replace(
        one, own={2: {"gain": 0.01, "gain_2": 0.01}}, words={2: {**one.words[2], "source_2": "joint_4"}}
    )
    other = replace(one, words={2: {"source": "joint_4"}})
    assert price(there, one) == 0.0
    assert price(there, two) >= need(now.context, 2)
    assert 0.0 < price(there, other) < price(there, two)


def test_a_mass_that_comes_is_paid_once_whichever_joints_the_model_has() -> None:
    now = fitted("clean")
    soft = {c: {"compliance": 0.02} for c in range(5)}
    lifted = Term("load_elasticity", "weight", {"payload": 0.1, "payload_from": 9.0}, soft)
    prices = []
    for count in (5, 4):
        known = Term("load_elasticity", "weight", {}, {c: soft[c] for c in range(count)})
        there = replace(now, context=knowing(now.context, Hypothesis(load_elasticity=known)))
        prices.append(price(there, lifted) - price(there, Term("load_elasticity", "weight", {}, soft)))
    assert prices[1] == pytest.approx(prices[0], rel=0.2)


def test_readings_that_are_late_have_no_formula_to_be_off_by() -> None:
    late, loose = context("late and loose"), context("backlash")
    assert sum(late.formed_misfit.values()) < 0.1 * sum(late.misfit.values())
    assert loose.formed_misfit[2] > 0.5 * loose.misfit[2]


def test_nor_have_setpoints_that_take_effect_late() -> None:
    """A loop that is slower is a delay and a rest, which the delay must not hide."""
    slow = recorded({"servo_delay": {"delay": 0.025}, "servo_bandwidth": {"relative": -0.3}}, 20.0)
    late = begun(first_look(ServoStage([servo_span(slow, TRUNK)], TRUNK))).context
    assert sum(late.formed_misfit.values()) < 0.1 * sum(late.misfit.values())


def test_a_zero_that_is_far_off_does_not_make_readings_late() -> None:
    """Dead bands look a little late on all joints."""
    alone, beside = context("loose"), context("loose beside a zero")
    assert beside.formed_misfit == pytest.approx(alone.formed_misfit, rel=0.01)


def test_the_truth_beats_everything_less_and_everything_more() -> None:
    ratio = Term("ratio_error", own={2: {"relative": 0.01}})
    right = fitted("two", BACKLASH, ratio)
    for wrong in (fitted("two"), fitted("two", BACKLASH), fitted("two", ratio)):
        assert beats(right, wrong)
        assert not beats(wrong, right)
    more = Term("viscous_lag", "proportional", own={2: {"time_constant": 1e-4}})
    assert beats(right, fitted("two", BACKLASH, ratio, more))


def test_what_the_motion_cannot_show_costs_more_than_any_residual() -> None:
    late = Term("wire_slip", own={2: {"step": 1e-3, "onset": 1e4}})
    now = costed(context("backlash"), Hypothesis(wire_slip=late))
    assert score(now) > UNSHOWN


def test_a_further_joint_makes_the_values_of_others_no_cheaper() -> None:
    """A joint of white noise beside one whose noise lasts, and so gains more by chance."""
    times = {"payload": 0.1, "payload_from": 9.0, "payload_until": 15.0}
    one = Term("load_elasticity", shared=times, own={3: {"compliance": 0.03}})
    two = replace(one, own=one.own | {0: {"compliance": 0.0}})
    now = fitted("picked up", one)
    lasting = tuple(replace(n, correlation=0.95 * (c == 3)) for c, n in enumerate(now.context.noise))
    context = replace(now.context, noise=lasting)
    cost = {c: float(context.count(c)) for c in now.cost}  # nothing but noise is left
    price_of = {len(t.own): price(Fit(Hypothesis({t.effect: t}), cost, context), t) for t in (one, two)}
    assert price_of[2] > price_of[1] + BETTER


def test_a_curve_costs_more_than_a_name_and_as_much_as_it_leaves() -> None:
    values = {f"value_{k}": 0.0 for k in range(24)}
    drawn = Term("unknown", own={2: {"low": -0.5, "high": 0.5, **values}}, words={2: {"on": "position"}})
    now = fitted("backlash")
    leaves = Fit(Hypothesis(unknown=drawn), dict(now.cost), now.context)
    little = Fit(Hypothesis(unknown=drawn), {**now.cost, 2: float(now.context.count(2))}, now.context)
    assert price(leaves, drawn) >= now.rest(2) - now.context.rest(2) * now.context.count(2)
    assert price(little, drawn) >= CURVE * need(now.context, 2)
    assert price(little, drawn) < price(leaves, drawn)


def test_a_slice_of_a_strong_rest_is_a_step_but_no_claim() -> None:
    now = fitted("two", BACKLASH)
    claimed = replace(now, context=replace(now.context, claims=True))
    assert now.rest(2) > now.context.count(2)
    assert price(claimed, BACKLASH) >= SLICE * now.rest(2)
    assert price(claimed, BACKLASH) > price(now, BACKLASH)


@pytest.mark.parametrize(("share", "slides"), [(0.4, True), (0.6, False)])
def test_a_drag_that_never_slides_is_told_from_nothing(share: float, slides: bool) -> None:
    """It would be a gain of its source, and by how it began an offset."""
    seen = context("clean")
    source = seen.views[0].wires[:, 1]
    values = {"gain": 0.1, "drag": 0.1, "reach": share * float(np.ptp(source))}
    drag = Term("joint_coupling", "drag", own={2: values}, words={2: {"source": seen.joints[1]}})
    assert (score(costed(seen, Hypothesis(joint_coupling=drag))) < UNSHOWN) == slides


def test_what_lasts_for_a_time_is_no_candidate_where_it_would_leave_a_strong_residual() -> None:
    """Else such candidates, which nobody may claim, keep those from being fitted that act all the time."""
    now = fitted("two")
    left = {2: now.cost[2]}
    assert not may_be_for_a_time(now.context, left, 0.5 * now.cost[2])
    assert may_be_for_a_time(now.context, left, now.cost[2])
    quiet = {2: 1.5 * now.context.count(2)}
    assert may_be_for_a_time(now.context, quiet, 0.2 * quiet[2])


def test_a_further_joint_makes_no_moment_cheaper() -> None:
    """What happens on several joints at once is one event, at the price of the dearest of them."""
    own = {c: {"compliance": 0.03, "from": 15.0} for c in (1, 4)}
    both = fitted("two give way", Term("load_elasticity", own=own))
    dear = replace(both.context, formed_misfit={1: 1e6, 4: 0.0})
    needs = {c: need(dear, c, both.rest(c)) for c in own}
    assert needs[1] > 2 * needs[4]
    one = Fit(both.hypothesis.without("load_elasticity", 4), both.cost, dear)
    two = Fit(both.hypothesis, both.cost, dear)
    prices = [price(fit, fit.hypothesis["load_elasticity"]) for fit in (one, two)]
    assert prices[1] >= prices[0] + needs[4]


def test_what_explains_one_joint_is_not_for_nothing_on_all() -> None:
    """A law is off by a share of what it explains: of one joint among those where nothing is amiss, too."""
    factor = Term("tension_error", shared={"factor": 3.0}, own={c: {} for c in range(5)})
    now = context("tension")
    noise = {c: float(now.count(c)) for c in now.columns}  # nothing but noise is left
    one_joint = replace(now, formed_misfit={c: 1e7 * (c == 4) for c in now.columns})
    asked = price(Fit(Hypothesis({factor.effect: factor}), noise, one_joint), factor)
    assert asked > 0.9 * FORMULAS * 1e7  # as on that joint alone, but for its name, which is chosen once


def test_chance_gains_no_more_than_all_that_an_encoders_steps_leave() -> None:
    """A joint that mostly rests shows each of few readings many times."""
    now = context("clean")
    stage = copy(now.stage)
    stage.coarse, stage.stands = [now.noise[0].std] * 5, [1e6] * 5
    resting = replace(now, stage=stage)
    assert need(resting, 2) == pytest.approx(STANDING * now.count(2), rel=0.01)
