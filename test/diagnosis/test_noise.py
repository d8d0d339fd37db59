"""The noise floor is that of the sensor, whatever the arm does."""

import numpy as np
import pytest
from scipy.signal import lfilter

from trunk_ros.diagnosis.data.noise import Noise, noise_of

N = 20_000
EVERYWHERE = np.ones(N, dtype=bool)


def coloured(correlation: float, std: float = 1e-4) -> np.ndarray:
    white = np.random.default_rng(1).normal(size=N) * std * np.sqrt(1 - correlation**2)
    return lfilter([1.0], [1.0, -correlation], white)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_size_and_colour_of_noise_are_found_under_a_slow_misfit(correlation: float) -> None:
    misfit = 0.01 * np.sin(np.arange(N) * 0.01)
    found = noise_of([coloured(correlation) + misfit], [EVERYWHERE])
    assert found.std == pytest.approx(1e-4, rel=0.1)
    assert found.correlation == pytest.approx(correlation, abs=0.08)


def test_rare_jumps_do_not_raise_the_floor() -> None:
    jumps = np.zeros(N)
    jumps[::500] = 0.01
    found = noise_of([coloured(0.0) + np.cumsum(jumps)], [EVERYWHERE])
    assert found.std == pytest.approx(1e-4, rel=0.05)


def test_whitened_noise_has_unit_variance_and_no_memory() -> None:
    noise = coloured(0.7)
    white = Noise(1e-4, 0.7).whiten(noise, np.arange(N) > 0)
    assert np.std(white) == pytest.approx(1.0, rel=0.03)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.03


@pytest.mark.parametrize("white", [1e-5, 1e-4, 1e-3])
def test_coloured_noise_under_an_encoders_steps_leaves_no_memory_either(white: float) -> None:
    noise = coloured(0.95) + white * np.random.default_rng(2).normal(size=N)
    follows = np.arange(N) % 500 > 0
    out = Noise(float(np.hypot(1e-4, white)), 0.95, white).whiten(noise, follows)
    assert np.std(out) == pytest.approx(1.0, rel=0.03)
    lags = [np.corrcoef(out[lag:], out[:-lag])[0, 1] for lag in (1, 2, 5, 20)]
    assert np.abs(lags).max() < 0.03
    np.testing.assert_allclose(np.std(out[~follows]), 1.0, rtol=0.4)


def test_a_signal_without_noise_gets_a_floor_that_can_be_divided_by() -> None:
    assert noise_of([np.zeros(N)], [EVERYWHERE]).std > 0.0
