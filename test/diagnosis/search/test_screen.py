"""What a linear look promises."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import on
from test.diagnosis.search.looks import context, fitted
from trunk_ros.chain import Chain
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import Candidate, extended, local_kinds
from trunk_ros.diagnosis.search.course import Course
from trunk_ros.diagnosis.search.fit import Fit, refit, refit_column
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.moves.spell import sized
from trunk_ros.diagnosis.search.residuals import Residuals
from trunk_ros.diagnosis.search.screen import PROMISED, Kept, Screen
from trunk_ros.diagnosis.search.size import reach
from trunk_ros.diagnosis.search.trial import may_win
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects import Effect, effect
from trunk_ros.model import Model, load_model
from trunk_ros.parameter import leading
from trunk_ros.recording.recording import JointSeries, Recording

DELAY = Term("sensor_delay", shared={"delay": 0.01}, own={c: {} for c in range(5)})


def test_a_look_at_all_joints_is_a_projection_on_all_values_and_the_change() -> None:
    now = fitted("late and soft", DELAY)
    soft = Term("load_elasticity", own={c: {"compliance": 0.01 * (c + 1)} for c in now.cost})
    late = now.hypothesis.copy()
    late["sensor_delay"].shared["delay"] = 0.017
    there = Hypothesis({**late.copy(), "load_elasticity": soft})
    screen = Screen(now.context, late)
    values = Residuals(now.context, late, now.context.columns)
    jacobian, rest = values.jacobian(late.free_values(values.free)), values(late.free_values(values.free))
    change = np.concatenate([screen.change(there, c) for c in now.context.columns])

    def left(*directions: np.ndarray) -> float:
        shapes = np.column_stack(directions)
        return float(np.sum((rest - shapes @ np.linalg.lstsq(shapes, rest, rcond=None)[0]) ** 2))

    before, after = left(jacobian), left(jacobian, change)
    assert after < 0.9 * before
    may = before - (before - after) / PROMISED
    assert screen.may_come_to(there, 0.0) == pytest.approx(may, rel=1e-6, abs=1e-6 * before)


def test_values_that_joints_share_follow_in_a_look_at_all_joints() -> None:
    late = fitted("late and soft", DELAY).hypothesis
    late["sensor_delay"].shared["delay"] = 0.019  # 1 ms off: the look moves it back
    now = fitted("late and soft")
    screen, nothing = Screen(now.context, late), late.copy()
    without = sum(map(screen.left, now.cost))
    assert screen.may_come_to(nothing, 0.0) < without - 100.0
    moved = refit(now.context, late).total
    assert screen.may_come_to(nothing, 0.0) == pytest.approx(moved, rel=0.02)


def test_a_look_tells_what_may_beat_the_best_from_what_cannot() -> None:
    best = fitted("tension", Term("tension_error", shared={"factor": 2.0}, own={c: {} for c in range(5)}))
    soft = Term("load_elasticity", own={c: {"compliance": 0.02} for c in range(5)})
    other, nothing = Hypothesis({"load_elasticity": soft}), fitted("tension")
    screen = Screen(best.context, nothing.hypothesis)
    assert may_win(nothing, best.hypothesis, screen, 0.0)
    assert not may_win(best, other, screen, 0.0)


def test_looks_that_were_kept_are_not_taken_again() -> None:
    now = fitted("backlash")
    screen, kinds = Screen(now.context, now.hypothesis, [2]), local_kinds(now.context)
    kept: Kept = {}
    found = screen.ranked(kinds, 2, len(kinds), kept=kept)
    done = now.context.work.done
    assert screen.ranked(kinds, 2, len(kinds), kept=kept) == found
    assert now.context.work.done == done
    assert "backlash" in {candidate.effect for candidate in found}


def test_what_comes_and_goes_hides_nothing_that_acts_all_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    now = fitted("clean")
    screen, kinds = Screen(now.context, now.hypothesis, [2]), local_kinds(now.context)[:4]
    gains = {kind.id: gain for kind, gain in zip(kinds, (9.0, 8.0, 7.0, 6.0), strict=True)}

    def forms(kind: type[Effect], column: int) -> list[Candidate]:
        comes = {"from": 12.0} if gains[kind.id] > 7.0 and kind.begins else {}
        return [Candidate(kind.id, kind.forms[0], column, comes, gains[kind.id])]

    monkeypatch.setattr(screen, "forms", forms)
    found = screen.ranked(kinds, 2, 2)
    assert [c.gain for c in found] == [9.0, 8.0, 7.0, 6.0][: 2 + sum(c.lasts for c in found[:2])]
    assert any(c.lasts for c in found)


def test_a_zero_within_the_play_is_seen_on_a_joint_that_stands_at_first() -> None:
    model, stamp = load_model("trunk"), np.arange(0.0, 30.0, 0.01)
    turns = np.where(stamp > 18.0, 0.2 * np.sin(2.0 * (stamp - 18.0)), 0.0)[:, None] * np.ones(5)
    there = Model(model.arm, {"zero_offset": {"offset": on(3, -4e-4)}})
    theta, _ = Chain(there, "wire").run(turns, stamp)
    theta = theta + np.random.default_rng(1).normal(size=theta.shape) * 1e-4
    theta[stamp < 18.0, 2] += 4e-4  # it stands in the middle of its play
    joints = model.arm.joints
    series = {
        "gearbox_states": JointSeries(stamp, joints, turns),
        "joint_states": JointSeries(stamp, joints, theta),
    }
    recording = Recording("stands", 0, float(stamp[-1]), series)
    first = begun(first_look(WireStage([wire_span(recording, model)], model)))
    (look, *_) = Screen(first.context, first.hypothesis).forms(effect("zero_offset"), 2)
    fitted = refit_column(first, extended(first.context, first.hypothesis, look), 2)
    assert look.gain > 0.9 * (first.cost[2] - fitted.cost[2]) > 1000.0


def test_a_stretch_before_the_friction_is_looked_for_from_the_beginning() -> None:
    nothing = fitted("upstream")
    found = Screen(nothing.context, nothing.hypothesis).all_everywhere(effect("load_elasticity"))
    assert found
    assert all(candidate.start.get("upstream") == 1.0 for candidate in found)
    behind = fitted("sag")
    found = Screen(behind.context, behind.hypothesis).all_everywhere(effect("load_elasticity"))
    assert found
    assert not any("upstream" in candidate.start for candidate in found)


def test_what_happened_to_another_joint_may_have_happened_to_a_further_one() -> None:
    one = Term("load_elasticity", own={1: {"compliance": 0.03, "from": 15.0}})
    now = fitted("two give way", one)
    start = Screen(now.context, now.hypothesis, [4]).local_form(effect("load_elasticity"), "weight", 4)
    assert start is not None
    assert start.start["from"] == now.hypothesis["load_elasticity"].own[1]["from"]
    assert start.start["compliance"] == pytest.approx(0.2, rel=0.05)


def test_a_slip_is_looked_for_at_the_sample_and_at_the_height_that_it_shows() -> None:
    now = fitted("slip")
    start = Screen(now.context, now.hypothesis, [1]).local_form(effect("wire_slip"), "", 1)
    assert start is not None
    assert start.start["onset"] == pytest.approx(17.0, abs=0.02)
    assert start.start["step"] == pytest.approx(2e-3, rel=0.02)


def test_how_a_wire_lay_is_told_by_what_was_measured_until_a_neighbour_moved_it() -> None:
    model, stamp = load_model("trunk"), np.arange(0.0, 40.0, 0.01)
    turns = np.zeros((len(stamp), 5))
    for column, begins, ends in ((1, 6.0, 18.0), (3, 28.0, 40.0)):
        moves = (stamp > begins) & (stamp < ends)
        turns[moves, column] = 0.3 * np.sin(2.0 * np.pi * (stamp[moves] - begins) / 6.0)
    dragged = {"joint_coupling": {"gain": on(4, 0.04), "source": ["", "", "", "joint_2", ""]}}
    chain = Chain(Model(model.arm, dragged), "wire")
    lay = np.linspace([0.0, 0.0, 0.0, 0.01, 0.0], np.zeros(5), 50)  # it had come from above
    theta, _ = chain.run(np.vstack([lay, turns]), np.concatenate([stamp[:50] - 1.0, stamp]))
    theta = theta[50:] + np.random.default_rng(1).normal(size=turns.shape) * 1e-4
    series = {
        "gearbox_states": JointSeries(stamp, model.arm.joints, turns),
        "joint_states": JointSeries(stamp, model.arm.joints, theta),
    }
    recording = Recording("lay", 0, float(stamp[-1]), series)
    first = begun(first_look(WireStage([wire_span(recording, model)], model)))
    drag = Term("joint_coupling", "angle", own={3: {"gain": 0.04}}, words={3: {"source": "joint_2"}})
    off = first.context.residual(0, Hypothesis({"joint_coupling": drag}), 3)
    assert abs(off[stamp < 6.0].mean()) < 2e-5
    assert np.sqrt(np.mean(off**2)) == pytest.approx(1e-4, rel=0.05)


def test_the_size_of_a_stop_is_how_far_it_does_not_give_way() -> None:
    """Not the angle at which it stands: twice that would be nowhere near."""
    stop = effect("hard_stop")
    start = {"upper": 0.5, "give": 0.2}
    assert leading(stop.own_parameters("upper")).name == "give"
    assert reach(stop, Candidate(stop.id, "upper", 0, start)) == pytest.approx((0.0625, 1.25))
    (one,) = sized(Fit(Hypothesis(hard_stop=Term(stop.id, "upper", own={0: start})), {}, context("clean")))
    half = one.taking(Hypothesis(hard_stop=Term(stop.id, "upper", own={0: dict(start)})), Course((0.5,)))
    assert half is not None
    assert half["hard_stop"].own[0] == {"upper": 0.5, "give": pytest.approx(0.6)}
