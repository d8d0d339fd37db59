"""Angles between the counts of an encoder."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.encoder import (
    CURVED,
    HIDDEN,
    WINDOWS,
    between_counts,
    count,
    counts,
    noises,
    smoothed,
)

STEP = 2 * np.pi / 2**14
T = np.arange(0.0, 40.0, 0.01)


def moving() -> np.ndarray:
    """Sweeps with rests between, rad."""
    return 0.4 * np.clip(1.5 * np.sin(0.5 * T), -1, 1) + 0.05 * np.sin(2.1 * T)


def series(position: np.ndarray, stamp: np.ndarray = T) -> JointSeries:
    return JointSeries(stamp, ("a",), position[:, None])


def rounded(angle: np.ndarray) -> np.ndarray:
    return np.asarray(np.round(angle / STEP) * STEP)


def test_what_lies_between_counts_is_less_than_half_as_far_off_as_the_counts():
    true = moving()
    seen = rounded(true)
    off = between_counts(series(seen)).position[:, 0] - true
    assert np.std(off) < 0.5 * np.std(seen - true)


@pytest.mark.parametrize("kick", [0.3 * STEP, 40 * STEP])
def test_no_angle_is_moved_by_more_than_half_a_count(kick):
    seen = rounded(moving() + kick * (np.arange(len(T)) % 37 == 0))
    moved = between_counts(series(seen)).position[:, 0] - seen
    assert np.abs(moved).max() <= 0.5 * STEP * (1 + 1e-9)


SCANS = 0.5 * np.abs((0.1 * T) % 2 - 1)  # rad, at one speed
STOPS = np.clip(SCANS, 0.1, 0.4)


@pytest.mark.parametrize("position", [moving(), SCANS, STOPS, np.zeros(len(T))])
def test_what_is_no_encoder_s_is_left_as_it_is(position):
    assert count(position) == 0.0
    assert (between_counts(series(position)).position[:, 0] == position).all()


ROWS = np.tile(np.repeat(np.arange(13), 13), 7)  # of a raster of stations
ASKED = np.random.default_rng(0).integers(-90, 90, 200)  # whole degrees


@pytest.mark.parametrize("places", [0.25 * ROWS - 1.5, np.deg2rad(ASKED)])
def test_where_a_recording_stops_to_measure_a_grid_was_asked_for(places: np.ndarray) -> None:
    asked = series(places, np.arange(float(len(places))))
    assert counts(asked) == 0.0
    assert between_counts(asked) is asked


def test_a_coarse_encoder_has_its_step() -> None:
    seen = 0.25 * np.round(6.0 * np.sin(2 * np.pi * 8.3 * T))  # 13 places, as a raster has
    assert count(seen) == pytest.approx(0.25)


def test_the_step_is_found_wherever_the_count_begins():
    assert count(rounded(moving()) + 0.123) == pytest.approx(STEP, rel=1e-9)


@pytest.mark.parametrize("speed", [0.3, 0.6, 0.97, 1.03, 1.98])
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_the_step_is_found_on_a_joint_so_slow_that_no_reading_is_far_from_the_last(
    speed: float, noise: float
) -> None:
    scans = speed * STEP * 1000 * np.abs((0.1 * T) % 2 - 1)  # ``speed`` counts a sample, ``noise`` in counts
    seen = rounded(scans + noise * STEP * np.random.default_rng(0).normal(size=len(T)))
    assert count(seen) == pytest.approx(STEP, rel=1e-9)


def test_the_step_is_found_on_a_joint_that_went_on_by_several_counts_between_all_samples() -> None:
    away = np.round(np.cumsum(4.0 + 2.0 * np.sin(0.7 * np.arange(400))))  # steps of 2 to 6 counts
    seen = np.concatenate([np.full(50, away[0]), away, away[::-1] + 3.0]) * STEP
    assert np.abs(np.diff(seen))[np.diff(seen) != 0].min() > 1.5 * STEP
    assert count(seen) == pytest.approx(STEP, rel=1e-9)


def test_unknown_angles_stay_unknown_and_those_beside_lost_ones_as_they_are():
    seen = rounded(moving())
    seen[500:510] = np.nan
    kept = (T < 20) | (T > 20.5)
    out = between_counts(series(seen[kept], T[kept])).position[:, 0]
    assert np.isnan(out[500:510]).all()
    assert np.isfinite(out[:500]).all()
    beside = np.flatnonzero(np.diff(T[kept]) > 0.1)[0]
    assert out[beside] == seen[kept][beside]


def test_noise_is_smoothed_where_it_is_more_than_a_count_hides():
    true, noise = moving(), 1.5 * STEP
    seen = rounded(true + np.random.default_rng(0).normal(size=len(T)) * noise)
    out = between_counts(series(seen)).position[:, 0]
    assert noises(series(seen))[0] == pytest.approx(noise, rel=0.2)
    assert np.std(out - true) < 0.5 * noise


def test_motion_is_no_noise():
    assert noises(series(moving()))[0] == 0.0
    assert noises(series(rounded(moving())))[0] < HIDDEN * STEP


@pytest.mark.parametrize("window", WINDOWS)
def test_parabolas_are_those_of_savitzky_and_golay(window: int):
    readings = moving()[:400]
    usual = savgol_filter(readings, window, CURVED, mode="interp")
    assert smoothed(readings, window) == pytest.approx(usual, abs=1e-12)


def test_counts_are_told_in_numbers_of_six_decimals():
    """Two steps of a 17-bit encoder then differ by 2 %, and a joint that moves fast has few small ones."""
    fine = 2 * np.pi / 2**17
    for first in range(0, 400, 8):
        readings = np.round(np.round(2.4 * np.sin(0.9 * T) / fine) * fine, 6)[first:]
        assert count(readings) == pytest.approx(fine, rel=1e-4), first


@pytest.mark.parametrize(("bits", "decimals"), [(14, 4), (15, 5), (16, 5), (17, 5), (18, 5), (20, 6)])
def test_counts_are_told_in_numbers_that_are_nearly_as_coarse(bits: int, decimals: int) -> None:
    """Printed numbers lie up to a fifth of a count off the encoder's grid, which counted as no grid."""
    fine = 2 * np.pi / 2**bits
    for first, path in enumerate((2.4 * np.sin(0.9 * T), moving())):
        printed = np.round(np.round(path / fine) * fine, decimals)[37 * first :]
        assert count(printed) == pytest.approx(fine, rel=1e-4)
        assert count(np.rad2deg(printed)) == pytest.approx(np.rad2deg(fine), rel=1e-4)


@pytest.mark.parametrize("decimals", [3, 5, 6])
def test_printed_numbers_alone_are_no_coarser_grid(decimals: int) -> None:
    """Of noise, of a joint that rests, and of whole numbers."""
    draws, rests = np.random.default_rng(0), np.arange(len(T)) % 400 < 300
    noise = draws.normal(size=len(T))
    for path in (0.4 * noise, np.cumsum(1e-3 * noise), 0.3 + np.where(rests, 0.0, moving()), moving()):
        for length in (60, 200, len(T)):
            assert count(np.round(path[:length], decimals)) in (0.0, pytest.approx(10.0**-decimals))
            whole = count(np.round(10.0**decimals * path[:length]) / 7.0)
            assert whole in (0.0, pytest.approx(1 / 7.0))
