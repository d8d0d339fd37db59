"""Hypotheses that differ in values alone are computed together, and come out as each by itself."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from test.diagnosis.search.looks import context
from trunk_ros.data.seen import abreast, at, now_of
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.candidates import Candidate, extended
from trunk_ros.diagnosis.stages.side_by_side import alike
from trunk_ros.effects import effect, registry

BASE = Hypothesis(
    backlash=Term("backlash", own={2: {"half_width": 1.5e-3}}),
    zero_offset=Term("zero_offset", own={2: {"offset": 1e-3}}),
)
JOINT = 2


def starts(kind: str, form: str) -> list[Hypothesis]:
    """The base with an effect on a joint, at some of its starts and somewhat larger."""
    there = context("sag")
    block = effect(kind)({}, {}, form)
    rest = 1e-3 * np.sin(20.0 * there.now(0, JOINT).gearbox[:, 0])
    some = block.starts(there.shown(JOINT), 0, rest)[:2]
    words = dict.fromkeys(block.texts, "joint_4")
    found = []
    for start in some:
        for size in (1.0, 1.3):
            values = {n: size * v if isinstance(v, float) else v for n, v in start.items()}
            found.append(extended(there, BASE, Candidate(kind, form, JOINT, values | words, free=True)))
    return found


def forms() -> Iterator[tuple[str, str]]:
    """The wire's effects that have a name, in each form."""
    for name, kind in registry().items():
        if kind.stage == "wire" and kind.named and kind.tried:
            yield from ((name, form) for form in kind.forms)


@pytest.mark.parametrize(("kind", "form"), list(forms()))
def test_each_comes_out_as_by_itself(kind: str, form: str) -> None:
    some, there = starts(kind, form), context("sag")
    alone = [there.predictions(hypothesis, JOINT)[0] for hypothesis in some]
    together = there.predictions_each([(hypothesis, JOINT) for hypothesis in some])
    assert np.ptp(np.array(alone), axis=0).max() > 0.0
    for one, (other,) in zip(alone, together, strict=True):
        assert np.abs(one - other).max() < 1e-12


def apart(*some: Hypothesis) -> bool:
    """Whether each of some hypotheses of a joint is computed by itself."""
    return len(list(alike([(hypothesis, JOINT) for hypothesis in some], True))) == len(some)


def test_what_differs_in_more_than_values_is_not_put_side_by_side() -> None:
    other_form = Term("stribeck_friction", "gaussian", own={2: {"amplitude": 1e-3, "velocity": 0.05}})
    one = Hypothesis(stribeck_friction=Term("stribeck_friction", "exponential", own=other_form.own))
    two = Hypothesis(stribeck_friction=other_form)
    assert not apart(one, one)
    assert apart(one, two)
    assert apart(one, Hypothesis())
    until = one.copy()
    until["stribeck_friction"].own[2]["until"] = 9.0
    assert apart(one, until)
    heavy = Hypothesis(
        load_elasticity=Term("load_elasticity", "weight", {"payload": 0.1}, {2: {"compliance": 0.1}})
    )
    light = heavy.moved(next(f for f in heavy.free([2]) if f.column is None), 0.2)
    assert apart(heavy, light)
    assert not apart(heavy, heavy)


def test_joints_are_computed_together_only_where_a_stage_can() -> None:
    both = [(Hypothesis(), 1), (Hypothesis(), 2)]
    assert list(alike(both, joint_by_joint=True)) == [[0], [1]]
    assert list(alike(both, joint_by_joint=False)) == [[0, 1]]


def test_work_is_counted_as_of_each_by_itself() -> None:
    there, some = context("sag"), starts("stribeck_friction", "gaussian")
    before = there.work.done
    there.predictions_each([(hypothesis, JOINT) for hypothesis in some])
    assert there.work.done - before == len(some) * len(there.views[0].span.grid)


def test_a_value_that_moves_leaves_the_hypothesis_as_it_was() -> None:
    free = BASE.free([2])
    moved = BASE.moved(free[0], 3e-3)
    assert moved["backlash"].own[2]["half_width"] == 3e-3
    assert BASE["backlash"].own[2]["half_width"] == 1.5e-3
    assert moved["zero_offset"] is BASE["zero_offset"]


@pytest.mark.parametrize("same", [True, False])
def test_columns_side_by_side_and_apart_again_are_what_they_were(same: bool) -> None:
    rng = np.random.default_rng(1)
    columns = [rng.normal(size=(5000, 1))] * 3 if same else [rng.normal(size=(5000, 1)) for _ in range(3)]
    whole = abreast(columns)
    np.testing.assert_array_equal(whole, np.concatenate(columns, axis=1))
    for column, each in zip(columns, whole.T, strict=True):
        np.testing.assert_array_equal(each, column[:, 0])
        assert each.flags.c_contiguous


def test_a_load_is_worked_out_only_where_an_effect_asks_for_it() -> None:
    there = context("sag")
    view = there.views[0].turned(there.views[0].angles + 0.1)
    seen = now_of(view, there.arm, 1)
    some = at(seen, np.array([3, 70]))
    assert "load" not in vars(view)
    np.testing.assert_array_equal(some.load, view.load[[3, 70], 1:2])
