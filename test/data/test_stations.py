"""An arm that goes from station to station, stands, and is read once at each."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import NOISE, RATE, SHORT, of_the_wires
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.data.excerpt import excerpt
from trunk_ros.data.rests import one_of_each_rest
from trunk_ros.errors import RecordingError
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

COUNT, STAND, MOVE = 180, 200, 150  # stations, samples of each, and in which the arm moves there

diagnose = partial(arms.diagnose, model=SHORT)


def visited(
    effects: dict[str, Any] | None = None, seed: int = 0, beyond: float = 0.0, read: int = 1
) -> Recording:
    """Setpoints, gearbox and joints, so many samples of each just before the arm moves on; ``beyond``: part
    of each way that the drives go further first.
    """
    model = Model(SHORT.arm, effects or {})
    rng = np.random.default_rng(seed)
    joints, stamp = model.arm.joints, np.arange(COUNT * STAND) / RATE
    stations = np.vstack([np.zeros(len(joints)), rng.uniform(-0.25, 0.25, (COUNT, len(joints)))])
    share = np.clip(np.arange(STAND)[:, None] / MOVE, 0.0, 1.0)
    eased = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    eased = eased + beyond * np.exp(-(((share - 0.9) / 0.05) ** 2))
    setpoints = np.vstack([a + eased * (b - a) for a, b in itertools.pairwise(stations)])
    phi, _ = Chain(model, "servo").run(setpoints, stamp)
    theta, _ = Chain(model, "wire").run(phi, stamp)
    rows = np.flatnonzero(np.arange(len(stamp)) % STAND >= STAND - read)
    seen: dict[str, Array] = {
        "setpoints": setpoints[rows],
        "gearbox_states": phi[rows],
        "joint_states": theta[rows] + NOISE * rng.normal(size=(len(rows), len(joints))),
    }
    series = {key: JointSeries(stamp[rows], joints, position) for key, position in seen.items()}
    return Recording("stations", 0, float(stamp[-1]), series)


def test_readings_are_taken_as_they_are_whatever_the_setpoints_say() -> None:
    recording = visited()
    span = wire_span(recording, SHORT)
    readings = recording.series["gearbox_states"].position
    np.testing.assert_allclose(span.gearbox[span.rows], readings, atol=1e-12)


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("load_elasticity", {"compliance": np.full(3, 0.05)}),
        ("tension_error", {"factor": 3.5}),
        ("backlash", {"half_width": np.full(3, 2e-3)}),
    ],
)
def test_what_differs_from_one_station_to_the_next_is_not_taken_for_noise(
    effect: str, values: dict[str, Any]
) -> None:
    result = diagnose([of_the_wires(visited({effect: values}))])
    assert effect in {f.effect for f in result.findings} | {e for f in result.findings for e in f.equivalents}
    assert result.verdict in ("explained", "partly_explained")


@pytest.mark.parametrize("read", [1, 10])
def test_stations_of_a_nominal_arm_show_nothing(read: int) -> None:
    assert diagnose([visited(read=read)]).verdict == "no_mismatch"


def test_of_several_readings_at_a_station_the_medians_count() -> None:
    """The motors have begun to move on by the last ones."""
    seen = of_the_wires(visited({"backlash": {"half_width": arms.on(2, 2e-3, 3)}}, read=10))
    seen.series["gearbox_states"].position[9::10] += 0.01
    rests = one_of_each_rest(seen)
    assert [len(each.stamp) for each in rests.series.values()] == [COUNT, COUNT]
    gone = seen.series["gearbox_states"].position[5::10] - rests.series["gearbox_states"].position
    assert np.abs(gone).max() < 1e-4
    (note,) = rests.notes
    assert note.startswith(f"read at {COUNT} rests, 10 times at each")
    result = diagnose([seen])
    assert [f.effect for f in result.findings] == ["backlash"]
    assert result.model.effects["backlash"]["half_width"][1] == pytest.approx(2e-3, rel=0.03)


def test_motions_with_pauses_of_the_recorder_are_no_stations() -> None:
    recording = arms.recorded(nominal=SHORT)
    paused = {key: one.rows(one.stamp % 2.0 < 1.0) for key, one in recording.series.items()}
    cut = replace(recording, series=paused)
    assert one_of_each_rest(cut) is cut


def test_of_too_few_stations_it_is_said_how_many_it_takes() -> None:
    few = visited(read=10).part(0.0, 40.0 * STAND / RATE)
    with pytest.raises(RecordingError, match="read at 40 rests, each of which counts once: stop 50 times"):
        diagnose([of_the_wires(few)])


def test_drives_that_settle_from_beyond_are_no_narrower_dead_band() -> None:
    """The nominal dead bands are 0.4 to 0.8 mrad, and these drives come back by a quarter of that."""
    result = diagnose([of_the_wires(visited(beyond=1.5e-3))])
    assert result.verdict == "no_mismatch", result.summary()


def test_what_such_drives_hide_of_a_dead_band_is_given_back() -> None:
    result = diagnose([of_the_wires(visited({"backlash": {"half_width": arms.on(2, 2e-3, 3)}}, beyond=5e-3))])
    assert [f.effect for f in result.findings] == ["backlash"]
    assert result.model.effects["backlash"]["half_width"][1] == pytest.approx(2e-3, rel=0.03)


def test_motors_that_were_recorded_on_their_way_arrive_as_recorded() -> None:
    """Joints are read at stops, the gearbox all the time: nothing of it is unseen."""
    seen, stamp = visited(), np.arange(COUNT * 20) * STAND / RATE / 20
    turned = np.stack([np.interp(stamp, seen.series["gearbox_states"].stamp, x) for x in
                       seen.series["gearbox_states"].position.T], axis=1)  # fmt: skip
    seen.series["gearbox_states"] = JointSeries(stamp, seen.series["joint_states"].joints, turned)
    span = wire_span(seen, SHORT)
    assert span.before
    assert not len(span.arrives)


def test_an_excerpt_keeps_only_arrivals_at_stops_that_are_in_it() -> None:
    joints, stamp = ("a",), np.arange(70_000) * 0.3
    angles = np.random.default_rng(2).uniform(-1.0, 1.0, (len(stamp), 1))
    series = {name: JointSeries(stamp, joints, angles) for name in ("gearbox_states", "joint_states")}
    whole = wire_span(Recording("long", 0, float(stamp[-1]), series), load_model("direct"))
    part = excerpt(whole)
    assert len(part.grid) < len(whole.grid)
    assert part.arrives.max() < len(part.grid) - 1
    np.testing.assert_array_equal(part.grid[part.arrives], part.grid[part.arrives + 1])
    gone = part.grid[part.arrives] - part.grid[part.arrives - 1]
    assert gone.max() == pytest.approx(0.3)


def test_topics_of_a_stop_belong_together_whichever_was_read_first() -> None:
    recording = visited()
    gearbox = recording.series["gearbox_states"]
    to_and_fro = gearbox.stamp + 0.02 * (-1.0) ** np.arange(COUNT)
    recording.series["gearbox_states"] = replace(gearbox, stamp=to_and_fro)
    assert diagnose([of_the_wires(recording)]).verdict == "no_mismatch"
