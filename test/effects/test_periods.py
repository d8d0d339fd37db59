"""Waves over places: as fine as the places can show them."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from trunk_ros.compiled import Array
from trunk_ros.effects.now import Now
from trunk_ros.effects.periods import FINER, _lines, periods
from trunk_ros.effects.wire.transmission_ripple import TransmissionRipple

STATIONS = np.linspace(-3.5, 3.5, 13)  # as far apart as those of a published cable robot
RASTER = np.tile(np.concatenate([STATIONS, STATIONS[::-1]]), 40)
NYQUIST = np.pi / (STATIONS[1] - STATIONS[0])


def lines(x: Array, cycles: float) -> tuple[float, ...]:
    noise = np.random.default_rng(0).normal(size=len(x))
    return periods(x, np.sin(cycles * x) + 0.1 * noise, 0.9, 120.0)


def test_lines_are_those_of_a_padded_transform() -> None:
    sums = np.random.default_rng(2).normal(size=317)
    padded = np.abs(np.fft.rfft(sums, FINER * len(sums)))
    np.testing.assert_allclose(_lines(sums, len(sums), 700), padded[:700], rtol=1e-12, atol=1e-12)


def test_long_times_take_hardly_more_memory_than_their_cells() -> None:
    blocks = np.array([0.0, 211.3, 1911.9, 2571.1, 5249.7, 6611.3]).repeat(5000)
    stamp = blocks + 0.01 * np.arange(30_000)
    rest = np.sin(2.0 * np.pi * 3.21 * stamp) + np.random.default_rng(3).normal(size=len(stamp))
    tracemalloc.start()
    (found, *_) = periods(stamp, rest, 1.0, 2.0 * np.pi * 25.0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found == pytest.approx(2.0 * np.pi * 3.21, rel=1e-3)
    cells = 8 * 25.0 * float(np.ptp(stamp))
    assert peak < 8 * np.dtype(float).itemsize * cells  # all lines at once: twice that


@pytest.mark.parametrize("off", [0.0, 1e-3])  # what drives stop beside their stations
@pytest.mark.parametrize("cycles", [2.0, 4.5, 60.0, 76.6])
def test_on_a_raster_no_wave_is_finer_than_two_stations(off: float, cycles: float) -> None:
    places = RASTER + off * np.random.default_rng(1).normal(size=len(RASTER))
    found = lines(places, cycles)
    assert max(found) <= NYQUIST * 1.01
    if cycles < NYQUIST:
        assert found[0] == pytest.approx(cycles, rel=0.06)


@pytest.mark.parametrize("cycles", [10.0, 60.0])
def test_places_that_lie_unevenly_show_finer_ones(cycles: float) -> None:
    rng = np.random.default_rng(1)
    for places in (RASTER + 0.15 * rng.normal(size=len(RASTER)), rng.uniform(-3.5, 3.5, 400)):
        assert lines(places, cycles)[0] == pytest.approx(cycles, rel=0.06)


def test_a_motion_shows_all_that_its_samples_do() -> None:
    moved = np.tile(np.concatenate([np.linspace(-1.0, 1.0, 2000), np.linspace(1.0, -1.0, 2000)]), 3)
    assert lines(moved, 100.0)[0] == pytest.approx(100.0, rel=0.01)


def test_three_places_tell_of_no_wave_that_they_hold_a_period_of() -> None:
    places = np.tile([-1.0, 0.0, 1.0, 0.0], 200)
    noise = np.random.default_rng(0).normal(size=len(places))
    assert periods(places, np.sin(30.0 * places) + noise, 1.05 * np.pi, 120.0) == ()


def test_the_steps_of_a_joints_own_encoder_are_no_ripple() -> None:
    """A 12 bit encoder without noise to round, of a joint that moves little and slowly."""
    stamp, step = np.arange(0.0, 40.0, 0.01), 2.0 * np.pi / 4096.0
    motor = (0.02 * np.sin(0.9 * stamp) + 0.01 * np.sin(2.3 * stamp))[:, None]
    still, rest = np.zeros_like(motor), (step * np.round(motor / step) - motor)[:, 0]
    seen = Now(stamp, np.full(4000, 0.01), motor, still, still, motor, motor, ("joint_1",), np.ones(1))

    def found(grain: float) -> list[float]:
        ripples = TransmissionRipple({}).starts(replace(seen, grain=grain), 0, rest)
        return [float(start["cycles_per_rev"]) for start in ripples]

    assert found(0.0)[0] == pytest.approx(4096.0, rel=0.02)
    assert all(cycles < 2048.0 for cycles in found(step))
