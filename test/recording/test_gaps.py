"""Samples in the place of lost ones."""

import numpy as np
import pytest

from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.gaps import bridged, gaps, late, missing

T = np.arange(0.0, 10.0, 0.01)
LOST = (T > 4.0) & (T < 5.2)
MOTION = np.column_stack([0.5 * np.sin(1.1 * T), np.cos(0.7 * T)])
SERIES = JointSeries(T, ("a", "b"), MOTION, np.gradient(MOTION, T, axis=0), 0.1 * MOTION)


def test_smooth_motion_goes_on_in_a_gap():
    out = bridged(SERIES.rows(~LOST))
    np.testing.assert_allclose(out.stamp, T, atol=1e-9)
    straight = np.interp(T, T[~LOST], MOTION[~LOST, 0])
    assert np.abs(out.position - MOTION).max() < 0.1 * np.abs(straight - MOTION[:, 0]).max()


def test_a_guide_shows_what_happened_in_a_gap_though_it_stands_off():
    kick = MOTION + 0.2 * np.exp(-(((T - 4.6) / 0.1) ** 2))[:, None]
    guide = JointSeries(T, ("a", "b"), kick + 0.03 + 0.001 * T[:, None])
    out = bridged(JointSeries(T[~LOST], ("a", "b"), kick[~LOST]), guide)
    np.testing.assert_allclose(out.position, kick, atol=1e-9)


def test_what_was_recorded_stays_and_effort_in_a_gap_is_unknown():
    out = bridged(SERIES.rows(~LOST))
    for name in ("position", "velocity", "effort"):
        assert (getattr(out, name)[~LOST] == getattr(SERIES, name)[~LOST]).all()
    assert np.isnan(out.effort[LOST]).all()


@pytest.mark.parametrize("stamp", [T, T[:1], np.array([0.0, 0.1, 3.0, 3.1, 9.0]), np.cumsum(T % 0.07 + 0.01)])
def test_nothing_is_missing_where_messages_keep_no_rate(stamp):
    assert not len(missing(stamp))


def test_a_stream_that_falls_silent_for_long_has_stopped():
    assert len(gaps(T[~LOST])) == 1
    assert not len(gaps(T[~LOST], longest=1.0))


def test_whoever_is_held_up_goes_on_where_it_was_and_what_is_lost_is_missing_in_the_course():
    lost = np.arange(len(T)) % 100 != 40
    assert not late(SERIES.rows(lost)).held.any()
    assert len(bridged(SERIES.rows(lost)).stamp) == len(T)
    late_stamp = np.cumsum(np.where(np.arange(len(T)) % 100 == 40, 0.03, 0.01))
    stalls = JointSeries(late_stamp, ("a", "b"), MOTION)
    seen = late(stalls)
    assert seen.after.tolist() == [*range(39, len(T), 100)]
    assert seen.held.all()
    assert seen.off.max() < 1e-4
    assert bridged(stalls) is stalls


@pytest.mark.parametrize("lost", [False, True])
def test_samples_that_jitter_are_late_and_none_is_missing(lost):
    stamp = np.arange(0.0, 60.0, 0.03) + 0.009 * np.random.default_rng(0).uniform(-1.0, 1.0, 2000)
    assert (np.diff(stamp) > 1.5 * np.median(np.diff(stamp))).sum() > 20
    there = np.ones(2000, dtype=bool)
    there[[300, 301, 302, 900, 901]] = not lost
    assert gaps(stamp[there]).tolist() == ([299, 896] if lost else [])
