"""Noise that wanders is told from physics before a search names it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from test.concealed.awkward import slow_noise
from test.diagnosis.arms import NOISE, on, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.discrepancy.curves import Place, curve_fit, design_of, ends, with_curve
from trunk_ros.diagnosis.discrepancy.smooth import smoothed
from trunk_ros.diagnosis.evidence.wandering import _bare, _put_together, steadied
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.resources.cores import on_cores
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.fit import Fit, costed
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.screen import Kept
from trunk_ros.diagnosis.search.slow_noise import (
    _own_or_theirs,
    likeliest_noise,
    told_from_noise,
    unlikely,
    wandering_in,
)
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.model import load_model

FORGETS = 0.97  # from sample to sample
WANDERS = 2.0 * NOISE  # rad


def left(
    name: str = "",
    wanders: float = WANDERS,
    swings: float = 0.0,
    joints: tuple[int, ...] = (1,),
    forgets: float = FORGETS,
    known: dict[str, Any] | None = None,
    **values: object,
) -> Fit:
    """What a nominal arm leaves of one with an effect, of which some sensors wander: the second one."""
    recording = recorded({name: values} if name else {}, 30.0)
    shown = recording.series["joint_states"]
    steps = np.random.default_rng(5).normal(size=(len(joints), len(shown.stamp)))
    wander = np.zeros((len(shown.stamp), 5))
    wander[:, joints] = lfilter([1.0], [1.0, -forgets], steps * wanders * np.sqrt(1.0 - forgets**2)).T
    wander += swings * np.sin(2.0 * np.pi * shown.stamp / 12.0)[:, None] * (np.arange(5) == 1)
    series = {**recording.series, "joint_states": replace(shown, position=shown.position + wander)}
    model = replace(load_model("trunk"), effects=known or {})
    stage = WireStage([wire_span(replace(recording, series=series), model)], model, recording.units)
    return begun(first_look(stage))


def told(fit: Fit) -> set[int]:
    return set(told_from_noise(fit, lambda column: {}).context.wanders)


def test_it_is_found_where_it_is_and_has_its_size() -> None:
    fit = left()
    found = told_from_noise(fit, lambda column: {}).context
    assert set(found.wanders) == {1}
    assert found.noise[1].std == pytest.approx(np.hypot(WANDERS, NOISE), rel=0.3)
    assert found.noise[0] == fit.context.noise[0]


def test_it_is_the_same_on_two_cores_and_takes_the_same_work_and_looks() -> None:
    def seen(cores: int) -> tuple[Any, ...]:
        fit = left(joints=(1, 3))
        looks: dict[int, Kept] = {c: {} for c in range(5)}
        with on_cores(cores):
            context = told_from_noise(fit, looks.__getitem__).context
        return context.wanders, context.work.done, {c: [*kept] for c, kept in looks.items()}

    one = seen(1)
    assert set(one[0]) == {1, 3}
    assert seen(2) == one


def test_what_wanders_over_all_times_at_once_has_a_slower_part() -> None:
    one = left()
    before = likeliest_noise(one.context, one.hypothesis, 1)
    assert before[0].slow == (0.0, 0.0)
    assert likeliest_noise(one.context, one.hypothesis, 1) is before  # it is looked for once
    fit = left(wanders=0.0)
    span = fit.context.views[0].span
    wander = slow_noise(np.random.default_rng(5), len(span.stamp), WANDERS) * (np.arange(5) == 1)
    views = (replace(fit.context.views[0], span=replace(span, target=span.target + wander)),)
    (found,) = told_from_noise(
        costed(replace(fit.context, views=views), fit.hypothesis), lambda column: {}
    ).context.wanders.values()
    size, stays = found.slow
    assert size > NOISE
    assert stays > found.correlation


def test_it_stays_as_it_is_told_while_the_search_goes_on() -> None:
    found = told_from_noise(left(), lambda column: {})
    assert found.context.wanders
    assert found.context.weighed(found.hypothesis).noise[1] == found.context.noise[1]


@pytest.mark.parametrize(("joints", "noise"), [((0, 1, 3), {0, 1, 3}), ((1, 3), set())])
def test_what_goes_far_beyond_the_noise_is_noise_where_three_sensors_wander_alike(
    joints: tuple[int, ...], noise: set[int]
) -> None:
    """Physics has a size of its own on each joint."""
    assert told(left(wanders=6.0 * NOISE, joints=joints)) == noise


def test_what_goes_far_beyond_the_noise_is_none_also_where_some_was_told_before() -> None:
    found = told_from_noise(left(), lambda column: {})
    assert told(left(wanders=4.0 * NOISE)) == set()
    assert told_from_noise(found, lambda column: {}).context.noise == found.context.noise


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("thermal_drift", {"amplitude": on(3, 6e-4), "time_constant": np.full(5, 12.0)}),
        ("wire_slip", {"step": on(3, 5e-4), "onset": np.full(5, 17.0)}),
        ("viscoelastic_creep", {"gain": on(3, 0.01), "time_constant": 3.0}),
        ("backlash", {"half_width": on(3, 4e-4)}),
    ],
)
def test_physics_of_another_joint_is_not_taken_for_it(name: str, values: dict[str, object]) -> None:
    assert told(left(name, **values)) == {1}


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("wire_slip", {"step": on(2, 6e-4), "onset": np.full(5, 17.0)}),
        ("joint_coupling", {"gain": on(2, 4e-3), "source": ["", "joint_1", "", "", ""]}),
    ],
)
def test_nor_is_physics_of_its_own_joint(name: str, values: dict[str, object]) -> None:
    assert told(left(name, **values)) == set()


def over_time(fit: Fit) -> Hypothesis:
    """With a curve over time on the second joint."""
    place = Place("unknown", "time", *ends(fit.context, 1, "time"))
    design = design_of(fit.context, 1, place)
    values = smoothed(design, fit.context.whitened(fit.hypothesis, 1), place.curve.bend())[0]
    return with_curve(fit.hypothesis, place, 1, values)


def test_a_curve_that_only_follows_such_readings_gives_way_to_their_noise() -> None:
    fit = left()
    curve = curve_fit(fit.context, fit.hypothesis, 1)
    assert curve is not None
    assert {"on": "time"} in [term.words.get(1) for term in curve.hypothesis.values()]
    found = steadied(curve)
    assert not found.hypothesis
    assert set(found.context.wanders) == {1}


def test_such_a_curve_gives_way_also_where_a_noise_was_told_beside_it() -> None:
    """Half of the noise of a resting arm was jumps that had come first, and stayed."""
    fit = left()
    curve = over_time(fit)
    beside = likeliest_noise(fit.context, curve, 1)[0]
    found = steadied(costed(wandering_in(fit.context, {1: beside}), curve))
    assert not found.hypothesis
    assert found.context.wanders[1].std > beside.std


def test_what_such_a_curve_held_besides_has_its_name_then() -> None:
    """Jumps stood for a zero that was off, and for readings that wandered about it."""
    fit = left("zero_offset", forgets=0.9, offset=on(2, 3e-3))
    found = steadied(costed(fit.context, over_time(fit)))
    assert found.hypothesis.keys() == {"zero_offset"}
    assert found.hypothesis["zero_offset"].own[1]["offset"] == pytest.approx(3e-3, abs=1e-4)
    assert found.context.wanders[1].std < 2.0 * WANDERS


def test_what_a_model_carries_on_no_joint_stays_where_such_a_curve_goes() -> None:
    carries = {"load_elasticity": {"compliance": np.zeros(5), "payload": 0.4}}
    fit = left("zero_offset", forgets=0.9, known=carries, offset=on(2, 3e-3))
    found = steadied(costed(fit.context, over_time(fit))).hypothesis
    assert "zero_offset" in found
    assert found["load_elasticity"].shared == {"payload": 0.4}


@pytest.mark.parametrize(("form", "taken"), [("upper", True), ("lower", False)])
def test_a_name_is_put_to_that_of_another_joint_in_the_same_form_alone(form: str, taken: bool) -> None:
    """In another form it would have no value."""
    found = over_time(left())
    found["hard_stop"] = Term("hard_stop", "upper", own={0: {"upper": 0.5}})
    other = Hypothesis({"hard_stop": Term("hard_stop", form, own={1: {form: 0.4}})})
    together = _put_together(found, {1: other})
    assert together.keys() == {"hard_stop"}
    assert together["hard_stop"].own == {0: {"upper": 0.5}} | ({1: {"upper": 0.4}} if taken else {})
    assert "unknown" in found


def test_no_name_is_looked_for_where_the_work_is_done() -> None:
    fit = left("zero_offset", forgets=0.9, offset=on(2, 3e-3))
    now = costed(replace(fit.context, work=Work(most=0.0)), over_time(fit))
    before = now.context.work.done
    assert not _bare(now, 1)
    assert now.context.work.done == before


def test_a_curve_of_what_swings_stays() -> None:
    fit = left(swings=6.0 * NOISE)
    curve = curve_fit(fit.context, fit.hypothesis, 1)
    assert curve is not None
    assert {"on": "time"} in [term.words.get(1) for term in curve.hypothesis.values()]
    assert steadied(curve).hypothesis.keys() == curve.hypothesis.keys()


def test_a_noise_is_that_of_the_other_sensors_where_it_may_be() -> None:
    """Beside one's own a creep costs nothing that takes as long; beside theirs it is seen."""
    found = told_from_noise(left(joints=(0, 1, 3)), lambda column: {})
    noises = found.context.wanders
    others = replace(found.context, wanders={c: noises[c] for c in (0, 3)})
    noise, cost = _own_or_theirs(others, found.hypothesis, 1)
    assert (noise.correlation, noise.slow) in [(noises[c].correlation, noises[c].slow) for c in (0, 3)]
    assert noise.white == likeliest_noise(others, found.hypothesis, 1)[0].white
    assert cost == unlikely(others, noise, found.hypothesis, 1)
    alone = _own_or_theirs(replace(found.context, wanders={}), found.hypothesis, 1)
    assert alone == likeliest_noise(found.context, found.hypothesis, 1)
