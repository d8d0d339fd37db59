"""The noise floor is that of the sensor, whatever the arm does."""

import numpy as np
import pytest
from scipy.signal import lfilter

from test.diagnosis.arms import diagnose
from trunk_ros.chain import Chain
from trunk_ros.data.noise import STRIDES, Noise, differences_of, noise_of, off_by_chance, roughness_of
from trunk_ros.data.noises import Rest, noises
from trunk_ros.evaluate.score import score
from trunk_ros.evaluate.signals import Signal
from trunk_ros.evaluate.source import Prediction
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording

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


def test_what_rings_gives_noise_no_colour() -> None:
    """A link at 16 Hz after each step, at 250 Hz; differences of red and of 1/f noise never shrink."""
    rng, n = np.random.default_rng(7), 15_000
    white = 2.5e-4 * rng.standard_normal(n)
    knocks = np.zeros(n)
    knocks[::250] = 5e-3
    turn = 2.0 * np.pi * 16.0 / 250.0
    ringing = lfilter([1.0], [1.0, -2.0 * 0.99 * np.cos(turn), 0.99**2], knocks)
    red = lfilter([np.sqrt(1.0 - 0.9**2)], [1.0, -0.9], white)
    wandering = np.fft.irfft(np.fft.rfft(white) / np.sqrt(np.maximum(np.arange(n // 2 + 1), 1.0)))
    seen = [
        differences_of([x], [np.ones(n, bool)], STRIDES[-1]) for x in (white, white + ringing, red, wandering)
    ]
    assert [each.swings for each in seen] == [False, True, False, False]
    rests = [Rest([white + ringing], [np.ones(n, bool)], STRIDES[-1], 0.0, True) for _ in range(3)]
    assert [each.std for each in noises(rests)] == pytest.approx([2.5e-4] * 3, rel=0.3)


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


@pytest.mark.parametrize("slow", [(0.0, 0.0), (2e-4, 0.999)])
def test_how_likely_a_residual_is_follows_from_its_covariance(slow: tuple[float, float]) -> None:
    n, gaps = 400, (0, 7, 150)
    noise = Noise(float(np.linalg.norm([1e-4, 5e-5, slow[0]])), 0.9, 5e-5, slow)
    rest = np.random.default_rng(4).normal(size=n) * 1e-4
    follows, counted = ~np.isin(np.arange(n), gaps), np.arange(n)
    apart = np.abs(np.subtract.outer(counted, counted))
    piece = np.cumsum(~follows)
    covariance = 1e-8 * 0.9**apart + slow[0] ** 2 * slow[1] ** apart
    covariance = covariance * np.equal.outer(piece, piece) + 25e-10 * np.eye(n)
    expected = rest @ np.linalg.solve(covariance, rest) + np.linalg.slogdet(covariance)[1]
    assert noise.unlikely(rest, follows, counted) == pytest.approx(expected, rel=1e-9)


def test_noise_that_wanders_over_two_times_leaves_no_memory_either() -> None:
    steps = np.random.default_rng(3).normal(size=(2, N))
    parts = (0.8, 1e-4), (0.995, 2e-4)
    fast, slow = (
        std * lfilter([np.sqrt(1.0 - a**2)], [1.0, -a], each)
        for (a, std), each in zip(parts, steps, strict=True)
    )
    noise = fast + slow + 1e-4 * np.random.default_rng(4).normal(size=N)
    known = Noise(1e-4 * np.sqrt(6.0), 0.8, 1e-4, (2e-4, 0.995))
    out = known.whiten(noise, np.arange(N) % 2000 > 0)
    assert np.std(out) == pytest.approx(1.0, rel=0.03)
    lags = [np.corrcoef(out[lag:], out[:-lag])[0, 1] for lag in (1, 2, 5, 20, 100)]
    assert np.abs(lags).max() < 0.03
    assert known.goes_on == pytest.approx(1e-8 * (0.8 + 4 * 0.995))


def test_a_signal_without_noise_gets_a_floor_that_can_be_divided_by() -> None:
    assert noise_of([np.zeros(N)], [EVERYWHERE]).std > 0.0


STAMP = np.arange(6000) * 0.01
COUNT = 2 * np.pi / 2**13  # rad


def scans(seed: int) -> np.ndarray:
    """(n,) rad: slow scans to and fro of 10 s, each at about one count a sample."""
    speeds = np.random.default_rng(seed).uniform(0.96, 1.04, 6) * [1, -1, 1, -1, 1, -1]
    return COUNT * np.cumsum(np.repeat(speeds, 1000))


def counted(angle: np.ndarray) -> np.ndarray:
    noise = 0.06e-3 * np.random.default_rng(3).normal(size=angle.shape)
    return np.asarray(np.round((angle + noise) / COUNT) * COUNT)


def test_a_joint_that_scans_from_count_to_count_is_as_loud_as_its_encoder_s_steps() -> None:
    nominal = load_model("trunk")
    joints = nominal.arm.joints
    phi = np.column_stack([scans(j) for j in range(len(joints))]) / nominal.arm.ratio
    theta, _ = Chain(nominal, "wire").run(phi, STAMP)
    series = {
        "gearbox_states": JointSeries(STAMP, joints, phi),
        "joint_states": JointSeries(STAMP, joints, counted(theta)),
    }
    found = diagnose([Recording("scans", 1_750_000_000_000_000_000, STAMP[-1], series)])
    assert found.findings == []
    floors = [joint["noise_floor"] for joint in found.stages["wire"]["joints"].values()]
    assert min(floors) > 0.95 * COUNT / np.sqrt(12.0)


@pytest.mark.parametrize("rounded", [True, False])
def test_a_score_is_in_the_steps_of_an_encoder_and_exact_data_need_none(rounded: bool) -> None:
    angle = scans(0)
    seen = counted(angle) if rounded else angle
    signal = Signal("wire", "a", "rad", STAMP, seen, seen - angle)
    (row,) = score("scans", [Prediction("exact", [signal], [signal])])
    assert row.noise == pytest.approx(COUNT / np.sqrt(12.0) if rounded else 1e-9, rel=0.01)


def test_the_power_of_few_samples_is_known_by_chance() -> None:
    """Four standard deviations of what fourth differences make of white noise."""
    rng = np.random.default_rng(0)
    for count in (300, 3000):
        off = [
            noise_of([rest], [np.ones(count, dtype=bool)], longest=1).std ** 2 - 1.0
            for rest in rng.standard_normal((200, count))
        ]
        assert off_by_chance(count) == pytest.approx(4.0 * np.std(off), rel=0.3)


def test_noise_of_which_only_a_slow_part_is_left_is_whitened_as_well() -> None:
    """Of every so many readings the fast part goes on no more."""
    noise = Noise(1e-4, 0.5, 3e-5, (7e-5, 0.9995)).of_every(30)
    assert noise.correlation == 0.0
    slow = coloured(noise.slow[1], noise.slow[0])
    white = np.random.default_rng(3).normal(size=N) * np.sqrt(noise.std**2 - noise.slow[0] ** 2)
    rest = noise.whiten(slow + white, EVERYWHERE)
    assert abs(np.mean(rest[1:] * rest[:-1])) < 0.05


def test_readings_are_as_rough_as_the_noise_that_is_in_them() -> None:
    white = 3e-5 * np.random.default_rng(4).standard_normal(N)
    readings = np.sin(np.arange(N) / 500.0) + coloured(0.9) + white
    noise = Noise(float(np.hypot(1e-4, 3e-5)), 0.9, 3e-5)
    assert roughness_of([readings], [EVERYWHERE]) == pytest.approx(noise.roughness, rel=0.03)
