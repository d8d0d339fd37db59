"""Claims about awkward sensors and everyday motions: each spoils what it says, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from test.concealed.awkward import KINDS, Awkward, acting, draw_awkward, slow_noise, spoiled
from test.concealed.everyday import EVERYDAY, draw_motion
from test.concealed.masses import run_masses
from test.concealed.masses_arm import Arm
from test.concealed.nominal import COUNT, LIMIT, RATIO, V_MAX
from test.concealed.sensing import Run, Sensing, record
from test.concealed.trajectory import draw_reference


@pytest.fixture(scope="module")
def run() -> Run:
    """A clean arm, well recorded."""
    rng = np.random.default_rng(1)
    reference = draw_reference(rng, "mixed", np.arange(3000, dtype=np.float64) * 0.01)
    motion = run_masses([(0.0, Arm())], np.repeat(reference / RATIO, 5, axis=0))
    return record(rng, "mixed", reference, reference / RATIO, motion, Sensing(noise=1e-5))


def _spoiled(run: Run, kind: str, size: float) -> Run:
    return spoiled(np.random.default_rng(2), run, Awkward(kind, size))


def test_half_of_slow_noise_is_slower_than_the_tenth_part_of_its_band() -> None:
    noise = slow_noise(np.random.default_rng(1), 6000, 1e-4)
    power = (np.abs(np.fft.rfft(noise, axis=0)) ** 2).sum(axis=1)[1:]
    assert noise.std() == pytest.approx(1e-4)
    assert power[:300].sum() > 0.5 * power.sum()
    octaves = [power[n : 2 * n].sum() for n in (4, 32, 256, 2048 // 2)]
    assert max(octaves) < 4 * min(octaves)  # as much in every octave


def test_a_skewed_clock_moves_stamps_in_proportion_to_time_and_no_angle(run: Run) -> None:
    shown, other = (x.topics["joint_states"] for x in (run, _spoiled(run, "skew", 200.0)))
    late = (other["stamp"] - shown["stamp"]) * 1e-9
    assert late[0] == 0
    assert late[-1] == pytest.approx(30.0 * 200e-6, rel=0.01)
    np.testing.assert_array_equal(shown["position"], other["position"])


def test_latched_readings_repeat_and_are_late_by_half_their_period_and_more(run: Run) -> None:
    held = _spoiled(run, "latched", 0.04)
    position = held.topics["joint_states"]["position"]
    assert (np.diff(position, axis=0) == 0).all(axis=1).mean() == pytest.approx(0.75, abs=0.02)
    np.testing.assert_allclose(position, held.theta_clean, atol=1e-4)  # its truth is what it shows


def test_a_wrapped_reading_jumps_by_a_whole_turn(run: Run) -> None:
    t = np.arange(6000, dtype=np.float64) * 0.01
    reference = draw_motion(np.random.default_rng(3), "turning", t)
    motion = run_masses([(0.0, Arm())], np.repeat(reference / RATIO, 5, axis=0))
    shown = record(np.random.default_rng(1), "turning", reference, reference / RATIO, motion, Sensing())
    wrapped = _spoiled(shown, "wrapped", 1.0).topics["joint_states"]["position"]
    turns = (wrapped - shown.topics["joint_states"]["position"]) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    assert np.abs(turns).max() == pytest.approx(1.0)
    assert np.abs(wrapped).max() <= np.pi


def test_thinned_setpoints_are_some_of_those_that_acted(run: Run) -> None:
    thin, whole = (x.topics["setpoints"] for x in (_spoiled(run, "thinned", 1.0), run))
    assert len(thin["stamp"]) == pytest.approx(len(whole["stamp"]) / 4, abs=1)
    assert set(thin["stamp"]) < set(whole["stamp"])


def test_stations_leave_a_row_of_each_topic_per_second_in_which_the_arm_stands() -> None:
    t = np.arange(3000, dtype=np.float64) * 0.01
    reference = draw_motion(np.random.default_rng(3), "stations", t)
    motion = run_masses([(0.0, Arm())], np.repeat(reference / RATIO, 5, axis=0))
    run = record(np.random.default_rng(1), "stations", reference, reference / RATIO, motion, Sensing())
    left = _spoiled(run, "stations", 1.0)
    assert {len(topic["stamp"]) for topic in left.topics.values()} == {30}
    assert len(left.theta_clean) == 30
    assert np.abs(left.topics["gearbox_states"]["velocity"]).max() < 0.05


def test_a_wandering_latency_is_between_none_and_one_period() -> None:
    ramp = np.tile(np.arange(2000.0)[:, None], (1, COUNT))
    exact, slid = (acting(np.random.default_rng(1), ramp, x)[:9000, 0] for x in (False, True))
    late = exact - slid
    assert late.min() == 0
    assert (late <= 1).mean() > 0.99
    share = late.reshape(-1, 250).mean(axis=1)  # of half a second each
    assert share.min() < 0.25
    assert share.max() > 0.75


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_a_size_and_leaves_lengths_alike(run: Run, kind: str) -> None:
    out = spoiled(np.random.default_rng(2), run, draw_awkward(np.random.default_rng(4), kind))
    for topic in out.topics.values():
        assert len({len(column) for column in topic.values()}) == 1
    assert len(out.theta_clean) == len(out.topics["joint_states"]["stamp"])


@pytest.mark.parametrize("kind", [*EVERYDAY, "stations"])
def test_everyday_motions_stay_within_limits_and_what_servos_can(kind: str) -> None:
    t = np.arange(6000, dtype=np.float64) * 0.01
    reference = draw_motion(np.random.default_rng(5), kind, t)
    assert np.abs(reference).max() <= LIMIT
    still = np.abs(np.diff(reference, axis=0)).max(axis=1) == 0
    assert np.abs(np.diff(reference, axis=0)).max() / 0.01 / RATIO < 3 * V_MAX
    assert still.mean() > (0.6 if kind == "resting" else 0.02)
