"""Joint readings that were low-pass filtered before anybody recorded them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfilt, sosfiltfilt

from test.diagnosis.arms import SHORT, diagnose, of_joints, of_the_servos, of_the_wires, recorded, reshaped
from trunk_ros.data.put_right import as_diagnosed, put_right
from trunk_ros.data.sensing.filtered import Filtered, filtered
from trunk_ros.evaluate.score import score
from trunk_ros.evaluate.source import of_model
from trunk_ros.recording.recording import Recording

RATE, CUT = 250.0, 6.0
STD = 2e-4
FIRST_ORDER = 0.97  # correlation
PLAY = {"backlash": {"half_width": np.full(3, 1.3e-3)}}
STEP = 1e-6  # rad of a table's last digit


def smoothed(values: np.ndarray, order: int = 2) -> np.ndarray:
    """Without phase."""
    return np.asarray(sosfiltfilt(butter(order, CUT, fs=RATE, output="sos"), values, axis=0))


def made(effects: dict[str, Any] | None = None, seconds: float = 60.0) -> Recording:
    """An arm whose readings are as they were made, without noise."""
    return recorded(effects, seconds=seconds, noise=0.0, rate=RATE, nominal=SHORT)


def noisy(recording: Recording, noise: np.ndarray) -> Recording:
    """With noise (n, joints) of a standard deviation on its joints."""
    shown = recording.series["joint_states"].position
    return reshaped(recording, "joint_states", position=shown + STD * noise / noise.std(axis=0))


def white(recording: Recording) -> np.ndarray:
    """Noise (n, joints)."""
    return np.random.default_rng(7).normal(size=recording.series["joint_states"].position.shape)


def without_phase(recording: Recording, both: bool = True) -> Recording:
    """Filtered: the joints, or both sides."""
    noise = white(recording)
    scale = STD / smoothed(noise).std(axis=0)
    shown = recording.series["joint_states"].position + scale * noise
    out = reshaped(recording, "joint_states", position=smoothed(shown))
    if both:
        driven = recording.series["gearbox_states"].position
        out = reshaped(out, "gearbox_states", position=smoothed(driven), velocity=None)
    return out


def edge(recording: Recording) -> Filtered | None:
    """What is found in the joints' readings."""
    return filtered(recording.series["gearbox_states"], recording.series["joint_states"])


@pytest.fixture(scope="module")
def clean() -> Recording:
    """An arm without mismatch, filtered on both sides."""
    return without_phase(made())


@pytest.mark.parametrize("both", [True, False])
def test_the_edge_of_a_filter_is_found(both: bool) -> None:
    found = edge(without_phase(made(), both))
    assert found is not None
    assert found.frequency == pytest.approx(CUT, rel=0.3)
    assert found.alike == int(RATE / (2.0 * found.frequency))


def test_the_edge_is_found_beside_what_an_arm_does() -> None:
    assert edge(without_phase(made(PLAY))) is not None


def test_digits_that_a_table_leaves_out_hide_no_edge(clean: Recording) -> None:
    shown = clean.series["joint_states"].position
    assert edge(reshaped(clean, "joint_states", position=np.round(shown / STEP) * STEP)) is not None


def test_readings_that_are_missing_hide_no_edge() -> None:
    whole = without_phase(made())
    shown = whole.series["joint_states"].position.copy()
    shown[np.random.default_rng(3).choice(len(shown), 40, replace=False)] = np.nan
    shown[:2, 0] = shown[-2:, 1] = np.nan
    found, before = edge(reshaped(whole, "joint_states", position=shown)), edge(whole)
    assert found is not None
    assert before is not None
    assert found.frequency == pytest.approx(before.frequency, rel=0.1)


def test_the_edge_of_a_sensor_of_two_poles_is_found() -> None:
    arm = made()
    two = sosfilt(butter(2, CUT, fs=RATE, output="sos"), white(arm), axis=0)
    found = edge(noisy(arm, two))
    assert found is not None
    assert found.frequency == pytest.approx(CUT, rel=0.3)


def test_noise_that_is_white_or_of_first_order_was_not_filtered() -> None:
    arm = made()
    one = lfilter([1.0], [1.0, -FIRST_ORDER], white(arm), axis=0)
    for noise in (white(arm), np.asarray(one)):
        assert edge(noisy(arm, noise)) is None


def test_without_noise_nothing_was_filtered() -> None:
    for effects in ({}, PLAY):
        assert edge(made(effects)) is None


def test_a_link_that_swings_is_no_filter() -> None:
    swings = {"link_resonance": {"frequency": np.full(3, 8.0), "damping": np.full(3, 0.1)}}
    for std in (0.0, 1e-5):
        arm = made(swings)
        assert edge(noisy(arm, white(arm)) if std else arm) is None


def test_unfiltered_recordings_stay_as_they_are() -> None:
    arm = recorded(nominal=SHORT)
    assert put_right([arm], SHORT)[0][0].series["joint_states"] is arm.series["joint_states"]


def test_a_clean_arm_whose_readings_were_filtered_has_no_mismatch(clean: Recording) -> None:
    """It had been unexplained, hundreds of times the noise."""
    servo = diagnose(of_joints(of_the_servos(clean), "joint_2"), SHORT)
    result = diagnose(of_the_wires(clean), SHORT)
    assert servo.verdict == result.verdict == "no_mismatch"
    assert servo.stages["servo"]["compared"]
    floors = [joint["noise_floor"] for joint in result.stages["wire"]["joints"].values()]
    np.testing.assert_allclose(floors, STD, rtol=0.25)
    (told,) = (seen for seen in result.quality[clean.name]["observed"] if seen["kind"] == "filtered")
    assert told["value"] == pytest.approx(CUT, rel=0.3)
    assert "low-pass filtered at about" in told["statement"]


def test_a_dead_band_is_named_beside_a_filter_and_nothing_else() -> None:
    arm = without_phase(made(PLAY), both=False)
    (found,) = diagnose(arm, SHORT).findings
    assert "backlash" in (found.effect, *found.equivalents)


def test_what_is_scored_has_the_same_noise(clean: Recording) -> None:
    right = as_diagnosed(clean, SHORT)
    rows = score(clean.name, [of_model(right, "nominal", SHORT)])
    noise = [row.noise for row in rows if row.stage == "wire"]
    np.testing.assert_allclose(noise, STD, rtol=0.25)
