"""What begins or ends has to be seen on the same way on both sides of its moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.search.looks import context
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Term
from trunk_ros.diagnosis.search.credible import ends_within, hidden
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects import effect
from trunk_ros.model import load_model

STAMP = np.linspace(0.0, 40.0, 4001)


def seen(angle: np.ndarray, name: str = "backlash", jump: float | None = None, **moments: float) -> bool:
    """Whether an effect with moments shows on a joint that moves as ``angle`` (n,) does, and jumps once."""
    now = context("clean").now(0, 2)
    now = replace(now, stamp=STAMP, gearbox=angle[:, None], load=np.zeros((len(angle), 1)))
    return ends_within(
        effect(name)({n: np.array([t]) for n, t in moments.items()}), now, lambda at: at == jump
    )


def swings(begin: float, end: float, times: float) -> np.ndarray:
    """So many swings between two moments, at rest before and after."""
    share = np.clip((STAMP - begin) / (end - begin), 0.0, 1.0)
    return np.asarray(np.sin(2.0 * np.pi * times * share))


@pytest.mark.parametrize(("moment", "shown"), [(20.0, True), (0.2, False), (39.8, False)])
def test_a_beginning_is_seen_in_the_midst_of_motion_and_not_at_its_ends(moment: float, shown: bool) -> None:
    assert seen(swings(0.0, 40.0, 4.0), **{"from": moment}) == shown
    assert seen(swings(0.0, 40.0, 4.0), until=moment) == shown


def test_what_lasts_for_one_stroke_goes_by_the_direction() -> None:
    there_and_back = swings(0.0, 40.0, 1.0)
    assert not seen(there_and_back, **{"from": 10.0, "until": 30.0})
    assert not seen(there_and_back, until=10.0, from_2=30.0)
    assert seen(there_and_back, until=30.0)
    assert seen(swings(0.0, 40.0, 6.0), **{"from": 10.0, "until": 30.0})


def test_a_ratio_is_the_same_on_either_way_so_that_one_is_enough() -> None:
    there_and_back = swings(0.0, 40.0, 1.0)
    assert seen(there_and_back, "ratio_error", until=30.0)
    assert not seen(swings(10.0, 20.0, 3.0), "ratio_error", until=21.0)


def test_a_joint_that_stands_on_one_side_of_the_moment_does_not_show_it() -> None:
    assert not seen(swings(10.0, 20.0, 3.0), **{"from": 9.0})
    assert not seen(swings(10.0, 20.0, 3.0), until=21.0)
    assert seen(swings(10.0, 20.0, 3.0), until=15.0)


def test_what_acts_all_the_time_needs_no_motion() -> None:
    assert seen(np.zeros_like(STAMP))


def test_what_happens_while_a_joint_rests_is_seen_by_its_jump() -> None:
    late = swings(20.0, 30.0, 3.0)
    assert seen(late, "ratio_error", jump=12.0, **{"from": 12.0})
    assert not seen(late, "ratio_error", jump=12.0, **{"from": 12.0, "until": 35.0})
    assert not seen(np.zeros_like(STAMP), "ratio_error", jump=12.0, **{"from": 12.0})


@pytest.mark.parametrize(("angle", "shown"), [(0.2, True), (0.0, False)])
def test_a_joint_that_rests_away_from_its_zero_shows_when_its_ratio_changes(
    angle: float, shown: bool
) -> None:
    """At its zero a ratio makes no jump, so that nothing tells it from one that was always wrong."""
    looked = context("clean")
    view, column = looked.views[0], 2
    rests = view.span.gearbox.copy()
    rests[:, column] = angle / looked.arm.ratio[column] + np.where(
        view.span.grid > 20.0, 0.3 * np.sin(view.span.grid - 20.0), 0.0
    )
    span = replace(view.span, gearbox=rests)
    there = first_look(WireStage([span], load_model("trunk")))
    term = Term("ratio_error", own={column: {"relative": 0.02, "from": 12.0}})
    assert (hidden(there, term) == []) == shown


def test_what_grows_does_so_while_the_joint_moves() -> None:
    angle = swings(10.0, 30.0, 3.0)
    assert seen(angle, "load_elasticity", grown=20.0)
    assert seen(angle, "load_elasticity", grown=38.0)
    assert not seen(angle, "load_elasticity", grown=0.002)
    assert not seen(angle, "load_elasticity", grown=8.0)


@pytest.mark.parametrize(("onset", "shown"), [(0.05, False), (12.0, True), (39.9, False)])
def test_a_slip_at_an_edge_of_the_recording_is_not_seen(onset: float, shown: bool) -> None:
    slip = Term("wire_slip", own={1: {"step": 1e-3, "onset": onset}})
    assert (hidden(context("clean"), slip) == []) == shown


@pytest.mark.parametrize(("form", "shown"), [("relative", True), ("held", True), ("absolute", False)])
def test_a_link_that_does_not_ring_is_seen_where_its_wire_damps_it(form: str, shown: bool) -> None:
    """Damped against the arm it lags, as behind any damper."""
    damped = Term("link_resonance", form, own={1: {"frequency": 5.0, "damping": 0.6}})
    assert (hidden(context("clean"), damped) == []) == shown


def test_a_motor_that_turns_while_its_own_joint_stands_may_turn_another_one() -> None:
    now = context("clean").now(0, 2)
    angles = now.angles.copy()
    angles[:, 1] = 0.3  # held, or its wire slips
    held = replace(now, angles=angles, wires=now.wires)
    told = {"gain": np.array([0.1])}, {"source": (now.joints[1],)}
    assert effect("joint_coupling")(*told, "motors").credible(held)
    assert not effect("joint_coupling")(*told, "angle").credible(held)
