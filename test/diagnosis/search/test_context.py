"""A context never changes; work is counted, and ends a search with the best so far."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace
from functools import cache

import numpy as np
import pytest

from test.diagnosis.arms import of_joints, recorded
from test.diagnosis.search.looks import ARMS, context, fitted
from trunk_ros.data.align import wire_span
from trunk_ros.data.seen import now_of
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.descent import Desk
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.search.greedy import begun, search
from trunk_ros.diagnosis.search.score import score
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.moments import Payload
from trunk_ros.model import load_model


@cache
def two() -> Context:
    """What is looked at where two effects are at work, on one of two joints."""
    model, seen = load_model("trunk"), of_joints(recorded(ARMS["two"], 20.0), "joint_2", "joint_3")
    return begun(first_look(WireStage([wire_span(seen, model)], model))).context


def searched() -> tuple[Fit, Work]:
    """A whole search, and the work of it, of which there is more than enough."""
    work = Work(1e9, each=1000)
    return search(replace(two(), work=work), Desk()), work


once = cache(searched)


def test_a_context_cannot_be_changed() -> None:
    with pytest.raises(FrozenInstanceError):
        context("clean").noise = ()  # type: ignore[misc]


def test_looking_with_a_hypothesis_makes_a_new_context_and_leaves_the_old_one() -> None:
    old = context("sag")
    before = [view.load.copy() for view in old.views]
    sag = Hypothesis(load_elasticity=Term("load_elasticity", own={c: {"compliance": 0.5} for c in range(5)}))
    new = old.seen_with(sag)
    assert new is not old
    assert new.look == old.look + 1
    assert all(np.array_equal(a, view.load) for a, view in zip(before, old.views, strict=True))
    assert np.abs(new.views[0].load - before[0]).max() > 1e-4
    assert old.seen_with(Hypothesis()).look == old.look


def test_noise_is_what_a_hypothesis_leaves() -> None:
    old = context("backlash")
    new = old.weighed(fitted("backlash", Term("backlash", own={2: {"half_width": 1e-3}})).hypothesis)
    assert new.noise[2].std == pytest.approx(1e-4, rel=0.1)
    assert new.views is old.views


def test_rows_that_do_not_count_do_not_count() -> None:
    old = context("backlash")
    rows = np.arange(len(old.views[0].span.rows)) % 2 == 0
    assert old.only([rows]).count(2) == pytest.approx(old.count(2) / 2, abs=1)


def test_a_prediction_costs_its_steps() -> None:
    now = replace(context("clean"), work=Work())
    now.predict(0, Hypothesis(), 2)
    assert now.work.done == len(now.views[0].span.grid)


@pytest.mark.long
def test_a_search_that_runs_out_of_work_gives_the_best_so_far() -> None:
    start = two()
    steps = len(start.views[0].span.grid)
    whole, _ = once()
    short = search(replace(start, work=Work(150 * steps)), Desk())
    nothing = search(replace(start, work=Work(0)), Desk())
    assert short.context.work.over
    assert not whole.context.work.over
    assert score(whole) <= score(short) <= score(nothing)


def test_each_effect_that_is_found_is_granted_work_of_its_own() -> None:
    """An arm in which much is at work is searched for longer; what was granted is not taken back."""
    work = Work(100, each=20)
    for effects in (0, 2, 1, 2, 3):
        work.finds(effects)
    assert work.most == 160
    found, granted = once()
    assert granted.most - 1e9 >= 1000 * len(found.hypothesis) > 1000


def test_the_same_search_takes_the_same_steps_again() -> None:
    found = [(work.done, state.hypothesis.key(1), state.total) for state, work in (once(), searched())]
    assert found[0] == found[1]


def test_what_is_granted_on_top_does_not_add_up() -> None:
    """Each part that ends a search gets the same share of what was granted for it, spent or not."""
    for more in (20, 30):  # of 25
        work = Work(100, done=100)
        for _ in range(3):
            top = work.besides()
            assert top.most == 25
            top.done = more
            work.took(top)
        assert work.over
        assert work.done == 100 + 3 * more


def test_a_form_that_takes_longer_counts_as_more_steps() -> None:
    now = replace(context("sag"), work=Work())
    grid = len(now.views[0].span.grid)
    for form, steps in (("weight", 1), ("links", 2), ("held", 3)):
        own = {2: {"compliance": 0.5, "damping": 0.1}}
        sag = Hypothesis(load_elasticity=Term("load_elasticity", form, own=own))
        before = now.work.done
        now.predict(0, sag, 2)
        assert now.work.done - before == steps * grid
        before = now.work.done
        now.predictions_each([(sag, 2), (sag, 1)])
        assert now.work.done - before == (steps + 1) * grid


@pytest.mark.long
def test_a_search_that_runs_out_of_work_finds_out_how_what_it_put_in_last_is_what_it_is() -> None:
    """Wires that stretch under a weight that nobody declared: the weight is an option of the stretch."""
    start = context("payload")
    steps = len(start.views[0].span.grid)
    said: list[int] = []
    whole = Work()
    done = search(replace(start, work=whole), Desk(lambda _: said.append(whole.done)))
    assert "payload" in done.hypothesis["load_elasticity"].shared
    short = search(replace(start, work=Work(said[0] + steps)), Desk())
    assert short.context.work.over
    assert "payload" in short.hypothesis["load_elasticity"].shared


def test_when_a_payload_is_there_is_worked_out_once_for_all_masses_and_joints() -> None:
    view, when = context("picked up").views[0], (("from", 9.0),)
    loads = {
        (mass, c): now_of(view, view.arm, c, Payload(mass, when)).load for mass in (0.1, 0.2) for c in (1, 2)
    }
    assert [*view.there].count(when) == 1
    for c in (1, 2):
        bare = view.load[:, c : c + 1]
        assert loads[0.2, c] - bare == pytest.approx(2.0 * (loads[0.1, c] - bare))
        assert not (loads[0.1, c] - bare)[view.span.grid < 8.9].any()
        assert (loads[0.1, c] - bare)[view.span.grid > 9.1].all()
