"""What a linear look promises."""

from __future__ import annotations

import pytest

from test.diagnosis.search.looks import fitted
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import extended, local_kinds
from trunk_ros.diagnosis.search.fit import refit
from trunk_ros.diagnosis.search.screen import Kept, Screen
from trunk_ros.diagnosis.search.trial import may_win
from trunk_ros.effects import effect

DELAY = Term("sensor_delay", shared={"delay": 0.01}, own={c: {} for c in range(5)})


@pytest.mark.parametrize(
    ("arm", "name"),
    [("sag", "load_elasticity"), ("tension", "tension_error"), ("late and soft", "sensor_delay")],
)
def test_a_fit_leaves_no_less_than_a_look_says_it_may(arm: str, name: str) -> None:
    now = fitted(arm)
    screen = Screen(now.context, now.hypothesis)
    candidate = screen.everywhere(effect(name))
    assert candidate is not None
    there = extended(now.context, now.hypothesis, candidate)
    may = screen.may_come_to(there, candidate.gain)
    assert may <= refit(now.context, there).total
    assert may < now.total - candidate.gain


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
