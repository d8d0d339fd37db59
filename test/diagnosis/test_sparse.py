"""Recordings that are read so often that effects are chosen on some of the readings."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import recorded
from trunk_ros.data.align import wire_span
from trunk_ros.data.excerpt import LONG, PARTS, sparser
from trunk_ros.data.noise import WHITE
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.sparse import Sparse, apart, sparse
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.levels import ROWS
from trunk_ros.model import load_model
from trunk_ros.recording.signal.resample import FINE

RATE = 1000.0


def look(rate: float, count: int = 1) -> Context:
    """At nominal arms: as many steps of all joints as one of a long recording has, at 1 kHz."""
    nominal = load_model("trunk")
    seconds = 1.01 * LONG * PARTS * ROWS / RATE / count / len(nominal.arm.joints)
    made = [recorded(seconds=seconds, seed=seed, rate=rate) for seed in range(count)]
    return first_look(WireStage([wire_span(r, nominal) for r in made], nominal))


@pytest.fixture(scope="module")
def dense() -> Context:
    """Two recordings at 1 kHz."""
    return look(RATE, 2)


def test_what_is_read_no_more_often_than_it_has_to_be_is_searched_as_it_is() -> None:
    context = look(100.0)
    assert sparse(context) is context


def test_of_two_topics_in_turns_nothing_is_left_out() -> None:
    """Their stamps lie closer together than those of either."""
    made = recorded(seconds=1.1 * LONG * PARTS * ROWS / 200.0 / 5)
    late = made.series["joint_states"]
    turns = {**made.series, "joint_states": replace(late, stamp=late.stamp + 0.004)}
    nominal = load_model("trunk")
    span = wire_span(replace(made, series=turns), nominal)
    assert span.gearbox.size > LONG * PARTS * ROWS
    assert sparser([span]) is None


def test_what_is_read_too_often_is_searched_on_readings_that_are_as_far_apart_as_models_are_computed(
    dense: Context,
) -> None:
    some = sparse(dense)
    for view, whole in zip(some.views, dense.views, strict=True):
        steps = np.diff(view.span.stamp)
        assert FINE / 2.0 < steps.min() <= steps.max() <= FINE
        rows = np.searchsorted(whole.span.stamp, view.span.stamp)
        np.testing.assert_array_equal(whole.span.target[rows], view.span.target)
        np.testing.assert_array_equal(whole.span.valid[rows], view.span.valid)


def test_where_joints_stood_at_first_is_said_of_the_same_readings(dense: Context) -> None:
    some = sparse(dense)
    for view, whole in zip(some.views, dense.views, strict=True):
        for few, all_rows in zip(view.span.start, whole.span.start, strict=True):
            assert set(view.span.stamp[few]) <= set(whole.span.stamp[all_rows])


def test_noise_is_that_of_all_readings(dense: Context) -> None:
    some = sparse(dense)
    assert isinstance(some, Sparse)
    again = some.weighed(Hypothesis())
    for few, whole in zip(again.noise, dense.weighed(Hypothesis()).noise, strict=True):
        assert few.std == pytest.approx(whole.std)
        correlation = whole.correlation**some.every
        assert few.correlation == pytest.approx(correlation if correlation > WHITE else 0.0)


def test_a_reading_that_stays_the_same_counts_once_however_many_are_looked_at(dense: Context) -> None:
    stage = copy(dense.stage)
    stage.stands = [60.0] * 5
    some = sparse(replace(dense, stage=stage))
    assert isinstance(some, Sparse)
    assert some.stage.stands == pytest.approx([60.0 / some.every] * 5)
    assert stage.stands == [60.0] * 5


def test_readings_in_packets_are_as_many_as_their_mean_says(dense: Context) -> None:
    first, second = (view.span for view in dense.views)
    packets = np.floor(first.grid / 0.01) * 0.01 + (first.grid % 0.01) * 0.1
    found = sparser([replace(first, grid=packets), second])
    assert found is not None
    assert found[1] in (11, 12)


def test_a_recording_of_one_reading_says_nothing_of_how_often_it_was_read(dense: Context) -> None:
    first, second = (view.span for view in dense.views)
    few = {name: getattr(second, name)[:1] for name in ("rows", "target", "valid")}
    found = sparser([first, replace(second, **few, start=tuple(rows[:0] for rows in second.start))])
    assert found is not None
    assert found[1] in (11, 12)


def test_recordings_by_themselves_are_as_sparse_as_together(dense: Context) -> None:
    together = [len(view.span.grid) for view in sparse(dense).views]
    assert [len(part.views[0].span.grid) for part in apart(dense)] == together
