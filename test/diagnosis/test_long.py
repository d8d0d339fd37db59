"""Long recordings: effects are searched for on an excerpt, and judged on the whole."""

from __future__ import annotations

import weakref
from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import PAIR, diagnose, on, recorded
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.data.excerpt import LENGTH, LONG, PARTS, WARM, excerpt
from trunk_ros.data.seen import at
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.bank_weights import AMPLE, Source, thinned
from trunk_ros.diagnosis.discrepancy.memory import sources
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.moments import Payload
from trunk_ros.effects.wire.swinging_links import pushed
from trunk_ros.machine import CELLS
from trunk_ros.model import load_model
from trunk_ros.recording.recording import Recording

SECONDS = LONG * PARTS * LENGTH + 60.0


def gearbox_and_joints(recording: Recording) -> Recording:
    """The recording without setpoints, so that there is only the wire to look at."""
    return replace(recording, series={k: s for k, s in recording.series.items() if k != "setpoints"})


def test_a_short_recording_is_searched_as_a_whole() -> None:
    span = wire_span(recorded(seconds=40.0), load_model("trunk"))
    assert excerpt(span) is span


def test_a_slow_recording_is_searched_as_a_whole_however_long() -> None:
    """It has no more samples than a fast one of minutes; in six blocks of a minute few would be left."""
    rare = recorded(seconds=SECONDS)
    rare = replace(
        rare, series={k: s.rows(np.arange(len(s.stamp)) % 100 == 0) for k, s in rare.series.items()}
    )
    span = wire_span(rare, load_model("trunk"))
    assert excerpt(span) is span


def test_an_excerpt_has_the_stamps_and_samples_of_the_whole() -> None:
    span = wire_span(recorded(seconds=SECONDS), load_model("trunk"))
    part = excerpt(span)
    row = np.searchsorted(span.stamp, part.stamp)
    np.testing.assert_array_equal(span.stamp[row], part.stamp)
    np.testing.assert_array_equal(span.target[row], part.target)
    assert part.grid[0] == span.grid[0]
    assert part.stamp[-1] == pytest.approx(span.stamp[-1], abs=0.02)
    assert part.stamp.size == pytest.approx(PARTS * LENGTH * 100, rel=0.01)


def test_what_follows_a_gap_of_an_excerpt_does_not_count_until_it_has_been_forgotten() -> None:
    part = excerpt(wire_span(recorded(seconds=SECONDS), load_model("trunk")))
    begins = part.stamp[1:][np.diff(part.stamp) > 1.0]
    assert len(begins) == PARTS - 1
    for begin in begins:
        assert not part.valid[(part.stamp >= begin) & (part.stamp < begin + WARM)].any()
        assert part.valid[(part.stamp > begin + LENGTH - 5.0) & (part.stamp < begin + LENGTH)].all()


@pytest.mark.long
def test_a_jump_between_the_blocks_is_found_at_its_moment() -> None:
    part = excerpt(wire_span(recorded(seconds=SECONDS, nominal=PAIR), PAIR))
    gap = int(np.argmax(np.diff(part.stamp)))
    onset = float(part.stamp[gap : gap + 2].mean())
    slips = {"wire_slip": {"step": on(2, 5e-4, 2), "onset": on(2, onset, 2)}}
    made = recorded(slips, seconds=SECONDS, nominal=PAIR)
    result = diagnose([gearbox_and_joints(made)], PAIR)
    (found,) = result.findings
    assert (found.effect, found.joints) == ("wire_slip", ["joint_2"])
    assert found.parameters["joint_2"]["onset"]["value"] == pytest.approx(onset, abs=0.5)
    assert found.parameters["joint_2"]["step"]["value"] == pytest.approx(5e-4, rel=0.02)


@pytest.fixture(scope="module")
def looked() -> Context:
    """The first look at a short run."""
    nominal = load_model("trunk")
    return first_look(WireStage([wire_span(recorded(seconds=40.0), nominal)], nominal))


def test_looks_share_what_does_not_go_by_the_joints_angles(looked: Context) -> None:
    (view,) = looked.views
    other = view.turned(view.angles + 0.1)
    assert other.columns is view.columns
    assert other.cuts is view.cuts
    assert not np.array_equal(other.load, view.load)


def test_loads_and_masses_stay_where_joints_hardly_move(looked: Context) -> None:
    """What shakes a link goes by the curvature of the angles, and needs these more exactly."""
    (view,) = looked.views
    near, far = view.turned(view.angles + 1e-4, 0.01), view.turned(view.angles + 1.0, 0.01)
    assert near.masses() is view.masses()
    assert near.load is view.load
    assert near.apart(view.angles) > 0.0
    np.testing.assert_allclose(far.masses(), looked.arm.mass_matrix(view.angles + 1.0))


def test_what_pushes_a_link_is_worked_out_once_for_its_angles(looked: Context) -> None:
    (view,) = looked.views
    now, still = looked.now(0, 1), np.vstack([view.angles[0], 0.0 * view.angles[0]])
    push, own, _ = now.cached("push", lambda: pushed(now, 1, still))
    assert now.cached("push", lambda: pushed(now, 1, still))[0] is push
    np.testing.assert_allclose(own, looked.arm.mass_matrix(view.angles)[:, 1, 1])
    some = at(now, np.arange(50))
    assert some.cached("push", lambda: 0.0) == 0.0  # of other steps it is another
    np.testing.assert_allclose(pushed(some, 1, still)[0], push[:50])


def test_mass_matrices_are_kept_for_so_many_looks_as_fit_into_memory(looked: Context) -> None:
    (view,) = looked.views
    first, most = view.masses(), CELLS // len(view.angles)
    assert view.masses() is first
    np.testing.assert_allclose(
        view.masses(Payload(0.5)),
        looked.arm.mass_matrix(view.angles) + 0.5 * looked.arm.mass_lever(view.angles),
    )
    for k in range(most + 2):
        view.turned(view.angles + 1e-3 * k).masses()
    assert sum(what == "masses" for what, *_ in view.large) == most
    np.testing.assert_array_equal(view.masses(), first)


def test_sources_of_banks_are_made_one_at_a_time(looked: Context) -> None:
    """Their designs are by far the largest arrays of a diagnosis."""
    seen = list[weakref.ref[Array]]()

    def looked_at(source: Source) -> bool:
        there = any(ref() is not None for ref in seen)
        seen.append(weakref.ref(source.design))
        return there

    assert not any(map(looked_at, sources(looked, 2)))
    assert len(seen) > 3


def test_banks_are_weighed_on_a_bounded_number_of_rows() -> None:
    rows = [len(thinned(np.zeros(n))) for n in (1000, 99_999, 100_000, 359_000, 720_000)]
    assert rows[:2] == [1000, 99_999]
    assert all(AMPLE <= n < 2 * AMPLE for n in rows[2:])
