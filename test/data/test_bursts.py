"""Claims about bursts of noise: they are told from what rings, and count as much less."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import diagnose, of_the_wires, recorded
from trunk_ros.compiled import Array
from trunk_ros.data.bursts import bursts
from trunk_ros.recording.recording import Recording

STAMP = np.arange(6000) * 0.01
DURING = (STAMP > 20.0) & (STAMP < 25.0)
MASKS = [np.ones(len(STAMP), dtype=bool)] * 3


def noise(seed: int, times: float = 1.0) -> Array:
    loud = np.where(DURING, times, 1.0)
    return np.asarray(1e-4 * loud * np.random.default_rng(seed).standard_normal(len(STAMP)))


def test_when_they_begin_and_end_and_how_loud_they_are() -> None:
    physics = 3e-3 * np.sin(2 * np.pi * 0.3 * STAMP)
    ((begin, end, times),) = bursts([noise(k, 8.0) + physics for k in range(3)], MASKS, STAMP)
    assert begin == pytest.approx(20.0, abs=0.6)
    assert end == pytest.approx(25.0, abs=0.6)
    assert times == pytest.approx(8.0, rel=0.2)


def test_steady_noise_what_rings_and_what_one_joint_has_are_none() -> None:
    assert bursts([noise(k) for k in range(3)], MASKS, STAMP) == ()
    ringing = np.where(DURING, 3e-3, 0.0) * np.sin(2 * np.pi * 14.0 * STAMP)
    assert bursts([noise(k) + ringing for k in range(3)], MASKS, STAMP) == ()
    assert bursts([noise(0, 8.0), noise(1), noise(2)], MASKS, STAMP) == ()


def test_what_is_loud_whenever_a_joint_moves_is_none() -> None:
    """What is outside does not know when that is."""
    moves = (STAMP % 6.0) < 2.0
    speed, other = np.where(moves, 0.3, 0.0), np.where((STAMP % 7.0) < 2.0, 0.3, 0.0)
    loud = [noise(k) * np.where(moves, 8.0, 1.0) for k in range(3)]
    assert bursts(loud, MASKS, STAMP, [other, speed]) == ()
    assert len(bursts(loud, MASKS, STAMP, [other])) > 5


def test_one_burst_that_falls_on_a_motion_is_one() -> None:
    speed = np.where(DURING, 0.3, 0.0)
    assert len(bursts([noise(k, 8.0) for k in range(3)], MASKS, STAMP, [speed])) == 1


@pytest.mark.parametrize("gain", [0.0, 4e-4])
def test_what_is_small_beside_a_burst_is_seen_and_a_burst_is_nothing(gain: float) -> None:
    """In the mean over all of it the noise would be five times as large as what is there."""
    effects = {"ratio_error": {"relative": np.array([0.0, 0.0, gain, 0.0, 0.0])}} if gain else {}
    found = diagnose([_with_burst(of_the_wires(recorded(effects, seconds=40.0)), 2e-3)])
    assert [(f.effect, f.joints) for f in found.findings] == ([("ratio_error", ["joint_3"])] if gain else [])
    (seen,) = (o for quality in found.quality.values() for o in quality["observed"])
    assert seen["kind"] == "burst"


def _with_burst(recording: Recording, size: float) -> Recording:
    shown = recording.series["joint_states"]
    during = (shown.stamp > 12.0) & (shown.stamp < 17.0)
    more = size * np.random.default_rng(3).standard_normal(shown.position.shape) * during[:, None]
    series = {**recording.series, "joint_states": replace(shown, position=shown.position + more)}
    return replace(recording, series=series)
