"""Readings that no arm can have shown, and clocks that were set: no crash, little memory, nothing wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, on, recorded, reshaped
from test.recording.bombs import cost_of
from trunk_ros.data.align import wire_span
from trunk_ros.data.excerpt import excerpt, recorded_time
from trunk_ros.data.sensor_faults import wild, without_wild
from trunk_ros.data.spectrum import spectrum
from trunk_ros.effects.periods import periods
from trunk_ros.model import load_model
from trunk_ros.recording.read import read_parts, read_recording
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.gaps import LONGEST, missing
from trunk_ros.recording.write import write_recording
from trunk_ros.simulate import simulate

LOOSE = {"backlash": {"half_width": on(2, 8e-4)}}
WILD = (1e3, 1e6, -1e10, 1e18, 1e308)
DAY = 86400.0


@pytest.fixture(scope="module")
def whole() -> Recording:
    return recorded(LOOSE, 30.0)


def with_wild(recording: Recording, key: str, name: str, every: int = 700) -> Recording:
    """With a wild value in each column at every so-and-so-many-th sample, and in the first and last one."""
    values = getattr(recording.series[key], name).copy()
    for column in range(values.shape[1]):
        rows = [0, len(values) - 1, *range(30 + 5 * column, len(values) - 5, every)]
        values[rows, column] = np.resize(WILD, len(rows))
    return reshaped(recording, key, **{name: values})


@pytest.mark.parametrize("every", [700, 50])
@pytest.mark.parametrize(
    ("key", "name"),
    [("gearbox_states", "position"), ("gearbox_states", "velocity"), ("joint_states", "position")],
)
def test_single_wild_values_are_left_out_and_nothing_else_is(whole, key, name, every):
    given, broken = getattr(whole.series[key], name), with_wild(whole, key, name, every)
    kept = without_wild(broken)
    found, out = getattr(kept.series[key], name), getattr(broken.series[key], name) != given
    np.testing.assert_array_equal(np.isnan(found), out)
    np.testing.assert_array_equal(found[~out], given[~out])
    (note,) = kept.notes
    assert note.endswith(
        f"{out.sum()} wild values of {name} (joint_1, joint_2, joint_3, joint_4, joint_5) left out"
    )


@pytest.mark.parametrize("step", [0.0, 1e-4, 4e-3])
def test_a_jump_that_stays_and_one_sample_of_a_fast_move_are_not_wild(step):
    still = np.zeros(400)
    still[200:] = 0.3
    still[300:] += np.minimum(np.arange(100) * 0.02, 0.4)
    readings = step * np.round(still / step) if step else still
    assert not wild(readings).any()


def test_a_motor_that_mostly_stands_and_moves_as_the_recording_ends_is_not_wild():
    readings = 1e-6 * np.random.default_rng(0).standard_normal(5000)
    readings[2000:2050] += np.linspace(0.0, 0.3, 50)
    readings[2050:] += 0.3
    readings[-40:] += np.linspace(0.0, 0.3, 40)
    assert not wild(readings).any()
    assert not wild(readings[::-1]).any()


def test_a_motor_that_sets_off_as_the_recording_ends_is_not_wild():
    t = np.linspace(0.0, 1.5, 150)
    readings = np.where(t < 1.3, 0.0, 30.0 * (t - 1.3).clip(0.0) ** 2)
    readings += np.random.default_rng(0).normal(0.0, 1e-6, len(t))
    assert not wild(readings).any()
    assert not wild(readings[::-1]).any()


def test_stop_and_measure_commands_are_not_wild():
    assert not wild(np.random.default_rng(0).uniform(-1, 1, 500)).any()


def test_what_a_wild_gearbox_reading_hides_is_found(whole):
    broken = with_wild(with_wild(whole, "gearbox_states", "position"), "joint_states", "position", 50)
    result = diagnose([broken])
    assert [(f.effect, f.joints) for f in result.findings] == [("backlash", ["joint_2"])]
    predicted = simulate(broken, load_model("trunk")).series["joint_states"].position
    assert np.abs(predicted).max() < 1.0


def test_readings_that_are_wild_one_after_the_other_take_no_memory():
    x = np.random.default_rng(0).normal(size=3000)
    x[100:130] = np.geomspace(1e3, 1e18, 30)
    assert periods(x, np.sin(x), 0.5, 40.0) == ()
    assert periods(np.where(np.abs(x) > 100, 1e308, x), np.sin(x), 0.5, 40.0) == ()


def test_a_model_for_any_joints_is_aligned_with_setpoints_there(whole):
    span = wire_span(whole, load_model("direct"))
    assert span.joints == whole.joints
    assert span.valid.any()


# Clocks


def shifted(recording: Recording, off: float, first: int, last: int) -> Recording:
    """With the stamps of some samples of each topic moved by ``off`` s."""
    out = recording
    for key, series in recording.series.items():
        stamp = series.stamp.copy()
        stamp[first:last] += off
        out = reshaped(out, key, stamp=stamp)
    return out


def written(recording: Recording, path: Path) -> Path:
    first = min(float(each.stamp[0]) for each in recording.series.values())
    series = {key: replace(each, stamp=each.stamp - first) for key, each in recording.series.items()}
    start = recording.start_ns + round(first * 1e9)
    write_recording(path, replace(recording, series=series, start_ns=start))
    return path


@pytest.mark.parametrize("off", [-3600.0, -DAY, -1e9, -1_740_000_000.0])
def test_an_early_first_stamp_is_left_out_and_said(whole, tmp_path, off):
    bag = written(shifted(whole, off, 0, 1), tmp_path / "bag")
    read = read_recording(bag)
    assert read.duration == pytest.approx(whole.duration - 0.01)
    assert "messages stamped" in " ".join(read.notes)
    assert "earlier, left out" in " ".join(read.notes)
    assert len(read_parts(bag)) == 1
    cost = cost_of(simulate, read, load_model("trunk"))
    assert (cost.said, cost.megabytes < 300) == ("read", True)


@pytest.mark.long
def test_a_recording_whose_clock_was_set_is_two(whole, tmp_path):
    bag = written(shifted(whole, -1_740_000_000.0, 0, 1000), tmp_path / "bag")
    first, second = read_parts(bag)
    assert [len(each.series["joint_states"].stamp) for each in (first, second)] == [1000, 2000]
    assert [round(each.duration, 6) for each in (first, second)] == [9.99, 19.99]
    assert first.start_ns < 1e17 < second.start_ns
    assert "55.1 years later, a recording of its own" in " ".join(first.notes)
    assert read_recording(bag).start_ns == second.start_ns
    result = diagnose([bag])
    assert [(f.effect, f.joints) for f in result.findings] == [("backlash", ["joint_2"])]
    assert len(result.quality) == 2


def test_a_pause_is_no_hole(whole, tmp_path):
    """Nor are samples that come once in twenty minutes."""
    bag = written(shifted(whole, 500.0, 1500, 3000), tmp_path / "pause")
    (read,) = read_parts(bag)
    assert read.duration == pytest.approx(whole.duration + 500.0)
    rare = {
        key: replace(s.rows(np.arange(len(s.stamp)) < 200), stamp=1200.0 * np.arange(200))
        for key, s in whole.series.items()
    }
    (read,) = read_parts(written(replace(whole, series=rare), tmp_path / "rare"))
    assert len(read.series["joint_states"].stamp) == 200


def test_topics_of_different_clocks_are_one_recording_as_before(whole, tmp_path):
    other = reshaped(whole, "joint_states", stamp=whole.series["joint_states"].stamp + 1e8)
    (read,) = read_parts(written(other, tmp_path / "bag"))
    assert "are they of one clock?" in " ".join(read.notes)


def test_what_is_searched_of_a_long_recording_leaves_its_gaps_out(whole):
    span = wire_span(shifted(whole, -700.0, 0, 1), load_model("trunk"))
    assert recorded_time(span.grid)[-1] == pytest.approx(whole.duration, abs=1.1)
    assert excerpt(span) is span


def test_nothing_is_filled_into_a_hole():
    stamp = np.concatenate([np.arange(500) / 100, 1e9 + np.arange(500) / 100])
    assert len(missing(stamp)) == 0
    assert len(missing(stamp[:500], end=5.0 + LONGEST / 2)) == pytest.approx(100 * LONGEST / 2, rel=0.01)
    assert len(missing(stamp[:500], end=1e9)) == 0
    assert spectrum(stamp, np.sin(2 * np.pi * 3.0 * stamp))[0] == pytest.approx(3.0, abs=0.02)


def test_a_gearbox_that_falls_silent_is_simulated_without_memory(whole):
    gearbox = whole.series["gearbox_states"]
    late = np.where(gearbox.stamp > 20.0, gearbox.stamp + 30 * DAY, gearbox.stamp)
    silent = reshaped(whole, "gearbox_states", stamp=late)
    series = JointSeries(whole.series["setpoints"].stamp, gearbox.joints, whole.series["setpoints"].position)
    cost = cost_of(
        simulate, replace(silent, series={**silent.series, "setpoints": series}), load_model("trunk")
    )
    assert (cost.said, cost.megabytes < 300) == ("read", True)
