"""In which order changes are taken."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from test.diagnosis.search.looks import context, fitted
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search import descent, greedy
from trunk_ros.diagnosis.search.descent import (
    COARSE,
    LARGE,
    Desk,
    Group,
    Move,
    descend,
    descend_with,
    first_that_pays,
    only,
)
from trunk_ros.diagnosis.search.fit import Fit, costed, refit
from trunk_ros.diagnosis.search.greedy import search
from trunk_ros.diagnosis.search.moves import add

LITTLE, HALF, ALL = 1e-4, 8e-4, 1.5e-3  # rad of the half-width of joint 3, which is 1.5e-3
LESS, MORE = 3.2e-4, 4.5e-4  # by which between a fifth and a half of what LITTLE leaves is explained


def with_width(best: Fit, half_width: float) -> Fit:
    return costed(
        best.context, Hypothesis({"backlash": Term("backlash", own={2: {"half_width": half_width}})})
    )


def to(half_width: float, what: str = "width", **kind: bool) -> Move:
    """A change to one half-width."""

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        yield Group((what, 2), [2], lambda: [with_width(best, half_width)])

    return Move(f"to {half_width}", groups, **kind)


def half(best: Fit, desk: Desk, half_width: float = HALF) -> Iterator[Group]:
    """Half of it, or so much, which is not fitted."""
    stated = Term("backlash", own={2: {"half_width": half_width}}, given=frozenset({"half_width"}))
    yield Group("half", [2], lambda: [costed(best.context, Hypothesis({"backlash": stated}))])


def noting(
    tried: list[tuple[str, float]], name: str, what: str = "", again: bool = False, **kind: bool
) -> Move:
    """A change that leads nowhere, with a note of each try; ``again``: it is another one at each share."""

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        tell = (name, desk.share)
        yield Group(tell if again else what or name, [2], lambda: tried.append(tell) or [])

    return Move(name, groups, **kind)


def steps(*moves: Move) -> int:
    """In how many steps the search gets to the whole of it: what it is led to is fitted when nothing pays."""
    said: list[str] = []
    best = descend(fitted("backlash"), moves, Desk(said.append))
    assert best.hypothesis["backlash"].own[2]["half_width"] == pytest.approx(ALL, rel=1e-3)  # fitted anew
    return len(said)


def test_what_gains_much_is_taken_before_what_comes_first_and_gains_little() -> None:
    nothing = fitted("backlash")
    gain = nothing.cost[2] - with_width(nothing, LITTLE).cost[2]
    assert COARSE[1] < gain / nothing.rest(2) < COARSE[0]
    assert steps(to(LITTLE), to(ALL)) == 1


def test_among_what_gains_much_the_first_one_is_taken() -> None:
    assert steps(to(HALF), to(ALL)) == 2


def test_what_explains_most_comes_before_anything_is_mended() -> None:
    assert steps(to(HALF), to(ALL, grows=True)) == 1


@pytest.mark.parametrize(("new", "another"), [(HALF, ALL), (LESS, MORE)])
@pytest.mark.parametrize(("what", "taken"), [("backlash", 1), ("ratio_error", 2)])
def test_what_the_model_has_may_be_there_in_another_way_before_anything_is_made_up(
    what: str, taken: int, new: float, another: float
) -> None:
    nothing, said = fitted("backlash"), list[str]()
    stage = copy(nothing.context.stage)
    stage.known = with_width(nothing, LITTLE).hypothesis
    best = costed(replace(nothing.context, stage=stage), stage.known)
    adds = Move("new", partial(half, half_width=new), grows=True)
    descend(best, [to(another, what, settles=True), adds], Desk(said.append))
    assert len(said) == taken


def test_while_much_is_left_cheap_mends_come_before_what_explains_more_and_the_others_after_it() -> None:
    tried: list[tuple[str, float]] = []

    moves = [noting(tried, "swap"), noting(tried, "drop", cheap=True), noting(tried, "add", grows=True)]
    descend(fitted("backlash"), moves, Desk())
    large = [name for name, share in tried if share == COARSE[0]]
    assert large == ["drop", "swap"]  # what explains more was tried before anything else, in the same state
    assert tried[0] == ("add", LARGE)
    tried.clear()
    descend(fitted("backlash"), [*moves, to(HALF, cheap=True)], Desk())
    large = [name for name, share in tried if share == COARSE[0]]
    assert large[-3:] == ["drop", "add", "swap"]


def test_how_an_effect_is_what_it_is_competes_with_the_next_one_while_much_is_left() -> None:
    tried: list[tuple[str, float]] = []

    forms = [noting(tried, "form", "backlash", settles=True), noting(tried, "another's form", settles=True)]
    add = noting(tried, "add", again=True, grows=True)
    descend(fitted("backlash"), [*forms, add, Move("half", half, grows=True)], Desk())
    assert [name for name, share in tried if share > COARSE[0]] == ["add", "add", "form"]
    assert [name for name, share in tried if share == COARSE[0]] == ["add", "another's form"]


def test_where_nothing_but_noise_is_left_no_change_is_waited_for() -> None:
    shares: list[float] = []

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        shares.append(desk.share)
        return iter(())

    descend(fitted("clean"), [Move("any", groups)], Desk())
    assert shares == [0.0]


def test_a_move_on_one_thing_alone_tries_nothing_else() -> None:
    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        yield from (Group(what, [2], list) for what in ("this", "that"))

    one = only(Move("any", groups), "that")
    assert [group.what for group in one.groups(fitted("backlash"), Desk())] == ["that"]


def test_a_last_resort_waits_for_what_gains_much() -> None:
    tried: list[tuple[str, float]] = []
    last = noting(tried, "last", again=True, resort=True)
    descend(fitted("backlash"), [last, to(HALF), noting(tried, "other", again=True)], Desk())
    at = [share for name, share in tried if name == "last"]
    assert max(at) < COARSE[0] <= max(share for name, share in tried if name == "other")


def test_what_would_not_be_claimed_is_left_out_where_the_work_is_done(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    useless = Hypothesis({"zero_offset": Term("zero_offset", own={1: {"offset": 1e-6}})})
    spent = replace(context("clean"), work=Work(1.0))
    monkeypatch.setattr(greedy, "begun", lambda now: refit(now, useless))
    done = search(spent, Desk())
    assert not done.hypothesis
    assert done.context.work is spent.work
    assert spent.work.over


def test_what_no_name_explained_has_a_curve_where_the_work_is_done() -> None:
    spent = replace(fitted("rough").context, work=Work(1.0))
    done = search(spent, Desk())
    assert done.hypothesis.curved == {1}
    assert done.rest(1) < 0.2 * done.context.count(1)


def test_a_curve_gives_way_to_a_name_that_the_search_did_not_come_to() -> None:
    spent = replace(fitted("coupled").context, work=Work(1.0))
    done = search(spent, Desk())
    assert not done.hypothesis.curved
    assert done.hypothesis["joint_coupling"].own[3]["gain"] == pytest.approx(0.03, rel=0.05)


def test_what_could_not_gain_enough_is_not_tried() -> None:
    tried: list[tuple[int, float]] = []
    desk = Desk()

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        for column in (0, 2):
            yield Group(column, [column], lambda c=column: tried.append((c, desk.share)) or [])

    descend(fitted("backlash"), [Move("any", groups)], desk)
    assert (2, COARSE[0]) in tried
    assert (0, COARSE[0]) not in tried


def test_what_promises_too_little_waits_until_little_is_asked_for() -> None:
    tried: list[tuple[str, float]] = []
    nothing = fitted("backlash")
    little = 0.1 * nothing.rest(2)

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        for what, promise in (("much", np.inf), ("little", little), ("nothing", 0.0)):
            yield Group(what, [2], lambda w=what: tried.append((w, desk.share)) or [], lambda p=promise: p)

    descend(nothing, [Move("any", groups)], Desk())
    assert COARSE[1] < little / nothing.rest(2) < COARSE[0]
    assert tried == [("much", COARSE[0]), ("little", COARSE[1])]


def sagged(name: str, cost: dict[int, float], now: Fit) -> Fit:
    """A law of the wire's stretch on all joints, stated to leave so much."""
    values = {"load_elasticity": {"compliance": 0.05}, "wire_slack": {"compliance": 0.05, "moment": 0.01}}
    return Fit(Hypothesis({name: Term(name, own={c: dict(values[name]) for c in cost})}), cost, now.context)


@pytest.mark.parametrize(("share", "taken"), [(0.05, "load_elasticity"), (0.4, "wire_slack")])
def test_a_law_that_includes_another_has_to_beat_it_as_a_step_would(share: float, taken: str) -> None:
    now = fitted("sag")
    noise = {c: float(now.context.count(c)) for c in now.cost}
    plain, more = (
        sagged(name, {c: noise[c] + part * now.rest(c) for c in noise}, now)
        for name, part in (("load_elasticity", 0.2), ("wire_slack", 0.2 * (1.0 - share)))
    )

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        yield Group("law", best.cost, lambda: [more, plain])

    found = first_that_pays(now, [Move("law", groups)], Desk(share=COARSE[0]))
    assert found is not None
    assert list(found[1].hypothesis) == [taken]


@pytest.mark.parametrize(("part", "taken"), [(0.18, False), (0.0, True)])
def test_what_comes_and_goes_has_to_beat_what_stays_as_a_step_would(part: float, taken: bool) -> None:
    now = fitted("sag")
    noise = {c: float(now.context.count(c)) for c in now.cost}

    def sags(share: float, **moments: float) -> Fit:
        own = {c: {"compliance": 0.05, **moments} for c in noise}
        cost = {c: noise[c] + share * now.rest(c) for c in noise}
        return Fit(Hypothesis({"load_elasticity": Term("load_elasticity", own=own)}), cost, now.context)

    stays, goes = sags(0.2), sags(part, until=12.0)

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        yield Group("law", best.cost, lambda: [goes, stays])

    found = first_that_pays(now, [Move("law", groups)], Desk(share=COARSE[0]))
    assert found is not None
    assert bool(found[1].hypothesis["load_elasticity"].moments(0)) == taken


def test_what_was_tried_in_vain_within_a_move_is_not_tried_again() -> None:
    now, desk, tried = fitted("backlash"), Desk(share=COARSE[0]), []

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        yield Group("width", [2], lambda: tried.append(desk.share) or [])

    for _ in range(2):
        descend_with(now, [Move("in vain", groups)], desk)
    assert tried == [COARSE[0]]
    desk.share = 0.0
    descend_with(now, [Move("in vain", groups)], desk)
    assert tried == [COARSE[0]]
    for _ in range(2):
        descend_with(now, [Move("in steps", groups, descends=True)], desk)
    assert tried == [COARSE[0], COARSE[1]]


def test_what_cannot_come_to_the_goal_is_not_tried() -> None:
    now, tried = fitted("backlash"), []
    promise = 0.3 * now.rest(2)

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        yield Group("width", [2], lambda: tried.append(desk.goal) or [], lambda: promise)

    near, far = now.total - promise, now.total - 3.0 * promise
    for goal in (far, near):
        descend_with(now, [Move("any", groups)], Desk(share=COARSE[0]), goal)
    assert tried == [near]


def test_a_law_with_more_to_it_is_better_by_a_step_than_the_plainer_one_beside_another_effect() -> None:
    best = fitted("slack")
    terms = {
        "wire_slack": Term(
            "wire_slack", "sharp", own={c: {"compliance": 0.05, "threshold": 0.01} for c in range(5)}
        ),
        "load_elasticity": Term("load_elasticity", own={c: {"compliance": 0.05} for c in range(5)}),
        "ratio_error": Term("ratio_error", own={1: {"relative": 1e-3}}),
    }
    nearly = {c: best.context.least_noise(c) + 1e4 for c in best.cost}
    richer = Fit(Hypothesis({"wire_slack": terms["wire_slack"]}), nearly, best.context)

    def beside(cost: float) -> Fit:
        plain = Hypothesis({name: terms[name] for name in ("load_elasticity", "ratio_error")})
        return Fit(plain, {c: each + cost for c, each in nearly.items()}, best.context)

    def taken(rival: Fit) -> list[str]:
        move = Move("either", lambda now, desk: iter([Group("law", list(nearly), lambda: [richer, rival])]))
        found = first_that_pays(best, [move], Desk(share=COARSE[0]))
        assert found is not None
        return sorted(found[1].hypothesis)

    assert taken(beside(1e3)) == ["load_elasticity", "ratio_error"]
    assert taken(beside(2e4)) == ["wire_slack"]


@pytest.mark.parametrize("exchanges", [False, True])
def test_an_exchange_that_ends_where_it_began_is_no_step(exchanges: bool) -> None:
    """What it gains is what fits leave to each other: a curve had been exchanged for itself five times."""
    begun = with_width(fitted("backlash"), HALF)
    step = first_that_pays(begun, (to(ALL, descends=exchanges),), Desk())
    assert (step is None) is exchanges


def test_what_is_no_step_takes_no_place_of_what_was_put_aside() -> None:
    begun, desk = with_width(fitted("backlash"), LITTLE), Desk()
    less, exchange = to(HALF), to(ALL, descends=True)
    desk.puts_aside(less, with_width(begun, HALF), begun)
    desk.puts_aside(exchange, with_width(begun, ALL), begun)
    step = desk.put_aside(begun)
    assert step is not None
    assert step[0] is less


def test_no_further_trial_of_a_group_is_made_once_the_work_is_done() -> None:
    made: list[float] = []

    def groups(best: Fit, desk: Desk) -> Iterator[Group]:
        def trials() -> Iterator[Fit]:
            for width in (LITTLE, HALF, ALL):
                made.append(width)
                yield with_width(best, width)

        yield Group("widths", [2], trials)

    best = fitted("backlash")
    steps = len(best.context.views[0].span.grid) * len(best.context.columns)
    granted = replace(best, context=replace(best.context, work=Work(2 * steps)))
    found = first_that_pays(granted, [Move("widths", groups)], Desk())
    assert made == [LITTLE, HALF]
    assert found is not None
    assert found[1].hypothesis["backlash"].own[2]["half_width"] == HALF


def test_the_best_that_was_tried_is_made_where_the_work_ends_before_its_turn() -> None:
    best = fitted("backlash")
    spent = replace(best, context=replace(best.context, work=Work(1.0)))
    tried: list[tuple[str, float]] = []
    late = noting(tried, "after the work is done", grows=True)
    done = descend(spent, [to(LITTLE, grows=True), late], Desk())
    assert with_width(best, LITTLE).total > (1.0 - COARSE[0]) * best.total  # less than was asked for
    assert not tried
    assert "backlash" in done.hypothesis


def test_what_a_new_effect_hides_is_put_right_and_all_else_left_to_the_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now, steps = fitted("backlash"), list[Fit]()
    worse = Fit(now.hypothesis, {c: 2.0 * cost for c, cost in now.cost.items()}, now.context)
    monkeypatch.setattr(add, "_hides", lambda name, fit: not steps)
    monkeypatch.setattr(descent, "first_that_pays", lambda fit, *_: steps.append(fit) or (add.ADD, fit))
    assert add.shown_again(worse, Desk(), now, "backlash") is now
    assert steps == [now]
    assert add.shown_again(now, Desk(), worse, "backlash") is worse
    assert steps == [now]
