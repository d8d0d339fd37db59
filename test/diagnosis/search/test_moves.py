"""Each move makes of a hypothesis that is nearly right one that is right, and proposes nothing better for one
that is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import TRUNK, recorded
from test.diagnosis.search.looks import best_of, context, drawn_beside_a_ratio, fitted
from trunk_ros.data.align import servo_span
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.course import Course
from trunk_ros.diagnosis.search.descent import COARSE, Desk, Move, descend
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.looked_again import renewed
from trunk_ros.diagnosis.search.moves import MOVES, swap_all
from trunk_ros.diagnosis.search.moves.onset import dated
from trunk_ros.diagnosis.search.moves.option import put_down
from trunk_ros.diagnosis.search.moves.spell import sized
from trunk_ros.diagnosis.search.moves.swap_all import SWAP_ALL, with_more, with_what_it_stood_for
from trunk_ros.diagnosis.search.score import beats, prices, score
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.effects import effect
from trunk_ros.model import Model

MOVE = {move.name: move for move in MOVES}
BACKLASH = Term("backlash", own={2: {"half_width": 1e-3}})
SLIP = Term("wire_slip", own={1: {"step": 1e-3, "onset": 17.6}})
COUPLED = Term("joint_coupling", "angle", own={3: {"gain": 0.02}}, words={3: {"source": "joint_2"}})


def sag(columns: range, **shared: float) -> Term:
    return Term("load_elasticity", shared=shared, own={c: {"compliance": 0.02} for c in columns})


def improved(name: str, arm: str, *terms: Term) -> Fit:
    """What a move makes of a hypothesis; it has to be better."""
    now = fitted(arm, *terms)
    best = best_of(MOVE[name], now)
    assert best is not None
    assert beats(best, now)
    return best


def test_onset_finds_a_moment_that_a_fit_does_not_see() -> None:
    best = improved("onset", "slip", SLIP)
    assert best.hypothesis["wire_slip"].own[1]["onset"] == pytest.approx(17.0, abs=0.02)


def test_a_moment_that_is_best_at_the_end_of_what_was_looked_at_is_looked_for_further_on() -> None:
    off = Term("wire_slip", own={1: {"step": 2e-3, "onset": 12.6}})
    there = costed(context("slip"), Hypothesis({"wire_slip": off}))
    assert dated(there, "wire_slip", 1).hypothesis["wire_slip"].own[1]["onset"] == pytest.approx(
        17.0, abs=0.05
    )


def test_drop_leaves_out_what_is_not_missed() -> None:
    best = improved("drop", "backlash", BACKLASH, Term("ratio_error", own={2: {"relative": 1e-4}}))
    assert list(best.hypothesis) == ["backlash"]


def test_add_finds_ratio_and_zero_of_a_wheel_that_nobody_described_at_once() -> None:
    best = improved("add", "unknown wheel")
    assert best.hypothesis["ratio_error"].own[2]["relative"] == pytest.approx(-1.9, abs=1e-3)
    assert best.hypothesis["zero_offset"].own[2]["offset"] == pytest.approx(1.2, abs=1e-3)


def test_add_finds_what_acts_on_all_joints_also_where_two_of_five_have_more_of_something_else() -> None:
    best = renewed(improved("add", "loose, and worn on two"))
    assert best.hypothesis["tension_error"].shared["factor"] == pytest.approx(0.5, abs=0.01)
    assert best.hypothesis["friction_wear"].columns == [1, 2]


@pytest.mark.parametrize("heavier", [1.0, 30.0])
def test_add_finds_what_pulls_each_joint_by_a_friction_of_its_own(heavier: float) -> None:
    """Between the least and the largest of them lies an order of magnitude, on a strong arm as well."""
    friction = heavier * np.array([0.008, 0.008, 0.03, 0.1, 0.1])
    droop = {"gain": 0.05 / heavier, "friction": friction, "form": "weight_and_friction"}
    arm = replace(TRUNK.arm, link_mass=heavier * TRUNK.arm.link_mass)
    span = servo_span(recorded({"load_droop": droop}, 12.0, nominal=Model(arm)), Model(arm))
    now = begun(first_look(ServoStage([span], Model(arm))))
    best = best_of(MOVE["add"], now)
    assert best is not None
    assert list(best.hypothesis) == ["load_droop"]
    found = [best.hypothesis["load_droop"].own[c]["friction"] for c in range(5)]
    np.testing.assert_allclose(found, friction, rtol=0.02)


def test_what_several_joints_have_gives_way_to_what_acts_on_all_beside_what_others_had_for_it() -> None:
    best = improved(
        "swap_all", "tension",
        Term("backlash", own={c: {"half_width": 1e-3} for c in (0, 4)}),
        Term("presliding_hysteresis", "spread", own={c: {"width": 1e-3, "shape": 0.2} for c in (1, 2)}),
        Term("stribeck_friction", "hyperbolic", own={3: {"amplitude": 1e-3, "velocity": 3.0}}),
    )  # fmt: skip
    assert list(best.hypothesis) == ["tension_error"]
    assert best.hypothesis["tension_error"].shared["factor"] == pytest.approx(3.0, abs=0.05)


@pytest.mark.long
def test_add_exchanges_what_does_not_show_any_more_beside_what_is_added() -> None:
    """Links that ring in the place of a late sensor: beside soft wires they would not."""
    rings = Term("link_resonance", "absolute", own={c: {"frequency": 5.0, "damping": 0.3} for c in range(5)})
    now = fitted("late and soft", rings)
    assert "link_resonance" in now.hypothesis
    best = best_of(MOVE["add"], now)
    assert best is not None
    assert set(best.hypothesis) == {"sensor_delay", "load_elasticity"}


def test_add_knows_that_creep_may_pass_through_the_friction() -> None:
    best = best_of(MOVE["add"], fitted("creeping under friction"))
    assert best is not None
    assert best.hypothesis["viscoelastic_creep"].form == "upstream"
    assert best.hypothesis["viscoelastic_creep"].own[2]["gain"] == pytest.approx(0.004, rel=0.2)


def test_add_knows_wires_that_give_way_little_by_little_under_weight() -> None:
    best = best_of(MOVE["add"], fitted("giving way"))
    assert best is not None
    creep = best.hypothesis["viscoelastic_creep"]
    assert creep.form == "load"
    assert creep.own[0]["compliance"] == pytest.approx(0.02, rel=0.1)


def test_add_knows_friction_that_takes_time_to_fade() -> None:
    """By the motor's speed alone, what a film of oil does looks like nothing that friction would do."""
    best = best_of(MOVE["add"], fitted("oiled"))
    assert best is not None
    assert best.hypothesis["stribeck_friction"].form == "film"
    assert best.hypothesis["stribeck_friction"].own[1]["memory"] == pytest.approx(0.15, rel=0.1)


def test_shake_knows_links_that_stick_and_slip_on_soft_wires() -> None:
    soft = Term("load_elasticity", shared={"upstream": 1.0}, own={c: {"compliance": 0.08} for c in range(5)})
    found = improved("shake", "heavy upstream", soft).hypothesis["load_elasticity"]
    assert found.form == "held"
    assert found.own[0]["compliance"] == pytest.approx(0.08, rel=0.05)


def test_shake_comes_early_where_its_law_mends_much_before_it_is_fitted() -> None:
    """On wires that carry nothing it waits, as it takes the most time."""
    early = Desk(share=COARSE[0])
    soft = Term("load_elasticity", shared={"upstream": 1.0}, own={c: {"compliance": 0.08} for c in range(5)})
    there = costed(context("heavy upstream"), Hypothesis({"load_elasticity": soft}))
    (heavy,) = MOVE["shake"].groups(there, early)
    assert next(iter(heavy.trials())).hypothesis["load_elasticity"].form in ("links", "held")
    (light,) = MOVE["shake"].groups(fitted("upstream", sag(range(5), upstream=1.0)), early)
    assert not list(light.trials())


def test_form_finds_the_law_that_was_at_work() -> None:
    term = Term("stribeck_friction", "exponential", own={1: {"amplitude": 3e-3, "velocity": 0.04}})
    assert improved("form", "gaussian", term).hypothesis["stribeck_friction"].form == "gaussian"


def test_form_begins_at_the_values_there_are_and_leaves_out_joints_that_do_not_show_it() -> None:
    """One that stood for something else, too fast to be seen, had kept two others in a wrong form."""
    wrong = {
        1: {"frequency": 67.0, "damping": 0.002, "share": 0.5},
        2: {"frequency": 3.5, "damping": 0.03, "share": 0.95},
        4: {"frequency": 4.7, "damping": 0.02, "share": 0.8},
    }
    best = improved("form", "rings", Term("link_resonance", "beam", own=wrong))
    found = best.hypothesis["link_resonance"]
    assert found.form == "absolute"
    assert found.own[4]["frequency"] == pytest.approx(4.7, rel=0.01)
    assert best.rest(4) < 100.0


def test_form_finds_creep_over_two_decades_of_time() -> None:
    term = Term("viscoelastic_creep", "one_mode", own={2: {"gain": 0.02}}, shared={"time_constant": 5.0})
    found = improved("form", "creeping like a rope", term).hypothesis["viscoelastic_creep"]
    assert found.form == "spectrum"
    ends = sorted(found.shared.values())
    assert np.log(ends) == pytest.approx(np.log([0.5, 60.0]), abs=0.3)


def test_member_lets_a_joint_join_what_acts_on_all() -> None:
    assert improved("member", "sag", sag(range(1, 5))).hypothesis["load_elasticity"].columns == [
        0,
        1,
        2,
        3,
        4,
    ]


def test_member_begins_anew_where_a_value_was_led_to_where_it_changes_nothing() -> None:
    slack = {c: {"compliance": 0.05, "threshold": 0.04 - 0.01 * c} for c in range(4)}
    slack[4] = {"compliance": 0.3, "threshold": 900.0}
    best = improved("member", "slack", Term("wire_slack", "sharp", own=slack))
    assert best.hypothesis["wire_slack"].own[4]["threshold"] == pytest.approx(2e-3, rel=0.2)


def test_like_begins_at_what_the_joint_has_that_tells_an_effect_best() -> None:
    """A film of oil has many minima: on one joint the fit stays in a wrong one."""
    right, far = (
        {"amplitude": a, "velocity": v, "memory": m} for a, v, m in ((4e-3, 0.03, 0.15), (0.05, 0.02, 0.3))
    )
    best = improved("like", "oiled on two", Term("stribeck_friction", "film", own={1: right, 3: far}))
    assert best.hypothesis["stribeck_friction"].own[3]["amplitude"] == pytest.approx(3e-3, rel=0.05)
    assert best.hypothesis["stribeck_friction"].own[3]["memory"] == pytest.approx(0.15, rel=0.05)


def test_alike_gives_a_joint_all_that_another_one_has_in_the_place_of_all_it_has() -> None:
    """From a wrong pair no exchange of one effect leads to the right one."""
    best = improved(
        "alike",
        "alike",
        Term("backlash", own={1: {"half_width": 1.5e-3}}),
        Term("ratio_error", own={1: {"relative": 0.02}}),
        Term("stribeck_friction", "exponential", own={3: {"amplitude": 1e-3, "velocity": 0.1}}),
        Term("zero_offset", own={3: {"offset": 1e-3}}),
    )
    assert best.hypothesis["ratio_error"].own[3]["relative"] == pytest.approx(0.015, rel=0.05)
    assert best.hypothesis["backlash"].own[3]["half_width"] == pytest.approx(1e-3, rel=0.05)
    assert best.hypothesis.keys() == {"backlash", "ratio_error"}


def test_alike_gives_no_joint_what_follows_that_joint() -> None:
    now = fitted(
        "two",
        Term("backlash", own={2: {"half_width": 1.5e-3}}),
        Term("ratio_error", own={2: {"relative": 0.02}}),
        Term("joint_coupling", "angle", own={2: {"gain": 1e-3}}, words={2: {"source": "joint_4"}}),
        Term("zero_offset", own={3: {"offset": 1e-3}, 4: {"offset": 1e-3}}),
    )
    assert {group.what for group in MOVE["alike"].groups(now, Desk())} == {2, 4}


def test_alike_takes_what_is_allowed_of_joints_with_the_same_names() -> None:
    """One follows the joint itself, the other does not."""
    words = {1: {"source": "joint_3"}, 2: {"source": "joint_5"}}
    now = fitted(
        "two",
        Term("backlash", own={c: {"half_width": 1.5e-3} for c in (1, 2)}),
        Term("ratio_error", own={c: {"relative": 0.02} for c in (1, 2)}),
        Term("joint_coupling", "angle", own={c: {"gain": 1e-3} for c in (1, 2)}, words=words),
        Term("zero_offset", own={4: {"offset": 1e-3}}),
    )
    assert 4 in {group.what for group in MOVE["alike"].groups(now, Desk())}


def test_option_finds_the_payload() -> None:
    best = improved("option", "payload", sag(range(5)))
    assert best.hypothesis["load_elasticity"].shared["payload"] == pytest.approx(0.08, rel=0.05)


@pytest.mark.parametrize("arm", ["payload", "upstream", "picked up"])
def test_options_gain_no_more_than_they_promise(arm: str) -> None:
    now = fitted(arm, sag(range(5)))
    (group,) = (g for g in MOVE["option"].groups(now, Desk()) if g.what == "load_elasticity")
    gained = score(now) - min(score(trial) for trial in group.trials())
    assert gained > 0.0
    assert group.promise() > gained


def test_options_that_nothing_asks_for_promise_no_more_than_they_save() -> None:
    now = fitted("sag", sag(range(5)))
    (group,) = (g for g in MOVE["option"].groups(now, Desk()) if g.what == "load_elasticity")
    assert group.promise() < score(now) - now.total + 60.0


def test_source_leaves_out_a_joint_that_is_not_followed() -> None:
    two = Term(
        "joint_coupling", "angle", own={3: {"gain": 0.02, "gain_2": 1e-5}},
        words={3: {"source": "joint_2", "source_2": "joint_1"}},
    )  # fmt: skip
    assert improved("source", "coupled", two).hypothesis.get_words("joint_coupling", 3) == ("joint_2",)


def test_swap_puts_the_right_effect_in_the_place_of_a_neighbour() -> None:
    best = improved("swap", "backlash", Term("viscous_lag", "proportional", own={2: {"time_constant": 1e-3}}))
    assert "backlash" in best.hypothesis


def test_swap_all_says_once_what_all_joints_share() -> None:
    width = Term("backlash", own={c: {"half_width": 6e-4} for c in range(5)})
    best = improved("swap_all", "tension", width)
    assert list(best.hypothesis) == ["tension_error"]
    assert best.hypothesis["tension_error"].shared["factor"] == pytest.approx(3.0, rel=0.02)


def test_swap_all_has_a_plainer_law_with_what_the_richer_one_stood_for() -> None:
    """What was explained on a joint before is asked of a further effect there."""
    rubs = Term("load_dependent_friction", "sharp", own={4: {"gain": 0.03}})
    before, plain = fitted("rubbing", sag(range(5)), rubs), fitted("rubbing", sag(range(5)))
    better = with_what_it_stood_for(before, plain)
    assert better.hypothesis["load_dependent_friction"].own[4]["gain"] == pytest.approx(0.03, rel=0.1)
    assert with_what_it_stood_for(plain, plain) is plain


def test_event_dates_what_was_taken_for_lasting() -> None:
    best = improved("event", "loosened", Term("backlash", own={2: {"half_width": 1e-3}}))
    assert best.hypothesis["backlash"].own[2]["from"] == pytest.approx(12.0, abs=0.05)


def test_spell_drops_a_moment_that_nothing_speaks_for() -> None:
    wrong = Term("backlash", own={2: {"half_width": 1.5e-3, "from": 3.0}})
    assert "from" not in improved("spell", "backlash", wrong).hypothesis["backlash"].own[2]


def test_spell_lets_a_wire_slip_once_more() -> None:
    once = Term("wire_slip", own={1: {"step": 2e-3, "onset": 12.0}})
    found = improved("spell", "slips twice", once).hypothesis["wire_slip"].own[1]
    assert found == pytest.approx({"step": 2e-3, "onset": 12.0, "from_2": 25.0, "times_2": 1.6}, rel=0.02)


def test_a_wire_that_slips_begins_at_its_onset_alone() -> None:
    """A model file has no other beginning of it."""
    slips = Hypothesis(wire_slip=SLIP)
    (one,) = sized(Fit(slips, {}, context("slips twice")))
    assert one.taking(slips, Course((0.0, 1.0), (20.0,))) is None
    assert one.taking(slips, Course((1.0, 0.5), (20.0,))) is not None


def test_event_takes_a_payload_up() -> None:
    best = improved("event", "picked up", sag(range(5)))
    found = best.hypothesis["load_elasticity"].shared
    assert found["payload"] == pytest.approx(0.1, rel=0.1)
    assert found["payload_from"] == pytest.approx(9.0, abs=0.05)


def test_event_tells_what_gives_way_on_two_joints_from_a_payload() -> None:
    soft = Term("load_elasticity", own={c: {"compliance": 0.02} for c in (1, 4)})
    best = improved("event", "two give way", soft).hypothesis["load_elasticity"]
    assert not best.shared
    assert [best.own[c]["from"] for c in (1, 4)] == pytest.approx([15.0, 15.0], abs=0.1)


def test_swap_all_keeps_the_moments_of_what_it_exchanges() -> None:
    payload = {"payload": 0.1, "payload_from": 9.0}
    slack = Term(
        "wire_slack", "sharp", payload, {c: {"compliance": 0.03, "threshold": 50.0} for c in range(5)}
    )
    best = improved("swap_all", "picked up", slack).hypothesis
    assert list(best) == ["load_elasticity"]
    assert best["load_elasticity"].shared["payload_from"] == pytest.approx(9.0, abs=0.05)


def test_swap_many_moves_a_neighbour_off_all_joints_at_once() -> None:
    """Beside what acts on all joints alike, an effect that most have is exchanged on all of them."""
    width = Term("presliding_hysteresis", "dahl", own={c: {"width": 1e-4} for c in range(4)})
    now = fitted(
        "tension", Term("tension_error", shared={"factor": 2.0}, own={c: {} for c in range(5)}), width
    )
    best = best_of(MOVE["swap_many"], now)
    assert best is not None
    assert "presliding_hysteresis" not in best.hypothesis


def test_swap_many_finds_the_form_that_several_joints_show() -> None:
    """In its plainest form wear would be worse on two of them, and bar the way to another one."""
    loose = Term("backlash", own={c: {"half_width": 5e-4} for c in (0, 3, 4)})
    worn = improved("swap_many", "wears", loose).hypothesis["friction_wear"]
    assert (worn.form, worn.columns) == ("travel", [0, 3, 4])


@pytest.mark.parametrize(
    ("arm", "effect"), [("backlash", "backlash"), ("slip", "wire_slip"), ("sag", "load_elasticity")]
)
def test_add_finds_what_a_nominal_arm_lacks(arm: str, effect: str) -> None:
    assert effect in improved("add", arm).hypothesis


def test_restart_finds_a_pair_that_a_wrong_first_effect_bars() -> None:
    wrong = Term(
        "transmission_ripple", "sine", own={2: {"amplitude": 3e-4, "cycles_per_rev": 1.5, "phase": 0.0}}
    )
    best = improved("restart", "two", wrong)
    assert {"backlash", "ratio_error"} <= {term.effect for term in best.hypothesis.on(2)}


def test_a_curve_explains_what_no_name_does_but_costs_more_than_the_name() -> None:
    drawn = improved("curve", "two")
    assert drawn.hypothesis.curved == {2}
    named = fitted("two", BACKLASH, Term("ratio_error", own={2: {"relative": 0.01}}))
    assert beats(named, drawn)


def test_option_finds_on_which_side_of_the_friction_a_wire_stretches() -> None:
    best = improved("option", "upstream", sag(range(5)))
    assert best.hypothesis["load_elasticity"].shared["upstream"] == pytest.approx(1.0, abs=0.05)


def test_option_comes_back_from_the_wrong_end_of_a_share() -> None:
    """Where it acts, a share of none may be a minimum as well as all."""
    behind = Hypothesis(load_elasticity=sag(range(5), upstream=0.0))
    stuck = costed(fitted("upstream").context, behind)
    (group,) = (g for g in MOVE["option"].groups(stuck, Desk()) if g.what == "load_elasticity")
    best = min(group.trials(), key=score)
    assert best.hypothesis["load_elasticity"].shared["upstream"] == pytest.approx(1.0, abs=0.05)


def test_a_curve_takes_the_place_of_one_name_that_comes_in_many_steps() -> None:
    steps = {"relative": 1e-3, "from_2": 13.0, "times_2": 2.0, "from_3": 26.0, "times_3": 3.0}
    now = fitted("wearing", Term("ratio_error", own={2: steps}))
    assert now.beyond_noise(2) == 0.0
    found = best_of(MOVE["curve"], now)
    assert found is not None
    assert set(found.hypothesis) == {"unknown_gain"}
    assert found.hypothesis["unknown_gain"].words == {2: {"on": "time"}}
    ratio = Term("ratio_error", own={2: {"relative": 0.02}})
    assert best_of(MOVE["curve"], fitted("two", BACKLASH, ratio)) is None


def test_what_a_curve_can_do_is_dropped_beside_it() -> None:
    now = drawn_beside_a_ratio()
    best = best_of(MOVE["drop"], now)
    assert best is not None
    assert beats(best, now)
    assert "ratio_error" not in best.hypothesis
    assert best.hypothesis.curved == {1}
    assert best.cost[1] == pytest.approx(now.cost[1], rel=0.02)


def test_a_curve_comes_early_only_where_names_will_not_come_near_it() -> None:
    hopeless = [
        Term("ratio_error", own={1: {"relative": 1e-3}}),
        Term("backlash", own={1: {"half_width": 1e-4}}),
    ]
    assert improved("early_curve", "rough", *hopeless).hypothesis.curved == {1}
    assert best_of(MOVE["early_curve"], fitted("two", BACKLASH)) is None


@pytest.fixture(scope="module")
def right() -> list[Fit]:
    """A clean arm, and the truth about another."""
    return [fitted("clean"), fitted("backlash", BACKLASH)]


@pytest.fixture(scope="module")
def half() -> Fit:
    """A part of the truth."""
    return fitted("two", Term("backlash", own={2: {"half_width": 1e-3}}))


@pytest.mark.parametrize("move", MOVES, ids=lambda move: move.name)
def test_no_move_makes_anything_of_a_clean_arm_or_of_the_truth(move: Move, right: list[Fit]) -> None:
    for now in right:
        best = best_of(move, now)
        assert best is None or not beats(best, now)


@pytest.mark.parametrize("move", MOVES, ids=lambda move: move.name)
def test_trials_leave_the_hypothesis_that_they_begin_with_as_it_is(move: Move, half: Fit) -> None:
    before = {name: term.copy() for name, term in half.hypothesis.items()}
    best_of(move, half)
    assert before == dict(half.hypothesis)
    assert np.isfinite(half.total)


def test_no_form_keeps_values_of_another() -> None:
    """A stretch before the wire's friction, as links that swing: these know of no before and behind."""
    now = fitted("upstream", sag(range(5), upstream=1.0))
    desk = Desk()
    tried = [trial for group in MOVE["shake"].groups(now, desk) for trial in group.trials()]
    tried += [trial for group in MOVE["form"].groups(now, desk) for trial in group.trials()]
    terms = [term for trial in tried for term in trial.hypothesis.values()]
    assert {term.form for term in terms} > {"weight"}
    for term in terms:
        used = {p.name for p in effect(term.effect).used(term.form)}
        assert used >= {*term.shared, *(name for own in term.own.values() for name in own)}


def test_what_joints_had_each_for_itself_they_share_at_its_median_and_back() -> None:
    term = Term("servo_bandwidth", "apart", own={c: {"relative": v} for c, v in enumerate((0.1, 0.2, 0.9))})
    term.reform("alike")
    assert (term.shared, term.own) == ({"relative": 0.2}, {0: {}, 1: {}, 2: {}})
    term.reform("apart")
    assert (term.shared, term.own[2]) == ({}, {"relative": 0.2})


def test_what_all_joints_share_is_found_beside_one_that_has_more() -> None:
    lags = Term("viscous_lag", "first_order", own={c: {"time_constant": 0.01} for c in range(5)})
    best = best_of(SWAP_ALL, fitted("late, and one lags", lags))
    assert best is not None
    assert best.hypothesis["sensor_delay"].shared["delay"] == pytest.approx(0.006, rel=0.05)
    assert best.hypothesis["viscous_lag"].columns == [2]


def test_what_has_come_back_on_most_joints_comes_back_on_no_more_of_them() -> None:
    """Else nothing is left of what all share that shows by itself."""
    was = fitted("late and loose", Term("backlash", own={c: {"half_width": 2e-3} for c in range(5)}))
    wide = Term("tension_error", shared={"factor": 3.0}, own={c: {} for c in range(5)})
    once = swap_all._with_some_back(was, costed(was.context, Hypothesis(tension_error=wide)), "backlash")
    assert len(once.hypothesis["backlash"].columns) == 3
    again = swap_all._with_some_back(was, once, "backlash")
    assert again.hypothesis["backlash"].columns == once.hypothesis["backlash"].columns


def test_what_is_put_down_leaves_no_moments() -> None:
    carries = Term("load_elasticity", shared={"payload": 0.1, "payload_from": 9.0, "other": 1.0})
    put_down(carries, "payload")
    assert carries.shared == {"other": 1.0}


def test_what_is_added_may_be_a_law_with_more_to_it() -> None:
    """A wire that hardens is first a wire that stretches; what that leaves is no further effect's."""
    soft = Term("load_elasticity", shared={"upstream": 1.0}, own={c: {"compliance": 0.04} for c in range(5)})
    best = best_of(MOVE["add"], fitted("hardens upstream", soft))
    assert best is not None
    assert list(best.hypothesis) == ["wire_stiffening"]
    assert best.hypothesis["wire_stiffening"].shared["upstream"] > 0.8


def test_a_law_with_more_to_it_is_added_and_not_exchanged() -> None:
    best = fitted("sag", sag(range(5)))
    (group,) = (g for g in SWAP_ALL.groups(best, Desk()) if g.what == "load_elasticity")
    swapped = {name for trial in group.trials() for name in trial.hypothesis}
    added = {name for trial in with_more(best, Desk()) for name in trial.hypothesis}
    assert not swapped & {"wire_slack", "wire_stiffening"}
    assert added >= {"wire_slack", "wire_stiffening"}


def test_a_law_costs_what_it_includes_and_what_it_has_besides() -> None:
    """Else it would be a cheaper account of what a further effect explains."""
    best = fitted("sag", sag(range(5)))
    (slack, *_) = (t for t in with_more(best, Desk()) if "wire_slack" in t.hypothesis)
    assert prices(best.context, slack.hypothesis) > 1.9 * prices(best.context, best.hypothesis)


def test_friction_that_grows_with_the_load_is_no_wire_that_goes_slack() -> None:
    best = descend(fitted("gripping", sag(range(5))), (SWAP_ALL, MOVE["add"]), Desk())
    assert not best.hypothesis.keys() & {"wire_slack", "wire_stiffening"}
