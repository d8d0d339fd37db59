"""What may be tried on joints that show different things."""

from __future__ import annotations

from typing import Any, cast

from test.diagnosis.search.looks import fitted
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.search.candidates import plain_forms
from trunk_ros.diagnosis.search.screen import Screen
from trunk_ros.effects import effect
from trunk_ros.effects.effect import Motion


class OneWay:
    """A context of which some joints never come back."""

    def __init__(self, *columns: int):
        self.columns = columns

    def motion(self, column: int) -> Motion:
        return Motion(one_way=column in self.columns)


class Once:
    """A context of joints that go through a wide loop once."""

    def motion(self, column: int) -> Motion:
        return Motion(wide_loop=True, once=True)


def forms(name: str, one_way: Any, *columns: int) -> tuple[str, ...]:
    return plain_forms(effect(name), cast(Context, one_way), columns)


def test_joints_that_never_come_back_do_not_hide_what_acts_on_all() -> None:
    assert forms("tension_error", OneWay(0, 2), 0, 1, 2) == ("",)
    assert forms("tension_error", OneWay(0, 1, 2), 0, 1, 2) == ()
    assert forms("backlash", OneWay(0), 0) == ()


def test_a_wide_loop_that_is_gone_through_once_shows_nothing_of_time() -> None:
    assert forms("thermal_drift", Once(), 0) == forms("wire_slip", Once(), 0) == ()
    assert forms("backlash", Once(), 0) == ("",)


def test_a_refined_form_is_not_looked_at_first() -> None:
    assert "links" in effect("load_elasticity").forms
    assert "links" not in forms("load_elasticity", OneWay(), 0, 1)


def test_joints_of_very_different_sizes_begin_each_at_its_own() -> None:
    now = fitted("graded")
    every = Screen(now.context, now.hypothesis).all_everywhere(effect("load_elasticity"))
    found = max(every, key=lambda candidate: candidate.gain)
    sizes = [found.own[c]["compliance"] for c in found.columns]
    assert len(sizes) >= 4
    assert max(sizes) > 30.0 * min(sizes)
