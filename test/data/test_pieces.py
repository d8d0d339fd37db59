"""What is computed piece by piece, as of long recordings, is what it is as a whole."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import TRUNK, recorded
from trunk_ros import machine, servo_course
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.data.sensing.hum import hums
from trunk_ros.data.sensing.physics import along
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.resample import resample


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Of the nominal arm, its readings with a tone of one size."""
    return recorded(seconds=60.0)


@pytest.fixture
def in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """All is long."""
    monkeypatch.setattr(machine, "CELLS", 700)
    monkeypatch.setattr(servo_course, "AT_ONCE", 700)


def _humming(recording: Recording) -> tuple[JointSeries, JointSeries]:
    shown = recording.series["joint_states"]
    tone = 2e-4 * np.sin(2 * np.pi * 0.47 * shown.stamp[:, None] + np.arange(5.0))
    return recording.series["gearbox_states"], JointSeries(shown.stamp, shown.joints, shown.position + tone)


@pytest.fixture(scope="module")
def whole(recording: Recording) -> tuple[Array, list[float]]:
    """Where the gearboxes went, and the tone: frequency, size, standard deviation."""
    (hum,) = hums(*_humming(recording), TRUNK.arm)
    return wire_span(recording, TRUNK).source, [hum.frequency, hum.size, hum.std]


def test_where_a_servo_went_between_its_readings(
    recording: Recording, whole: tuple[Array, list[float]], in_pieces: None
) -> None:
    span = wire_span(recording, TRUNK)
    read, _ = resample(recording.series["gearbox_states"], span.grid)
    assert np.abs(whole[0] - read).max() > 1e-5  # led by its setpoints, not from reading to reading
    assert np.abs(whole[0] - span.source).max() < 1e-9


def test_a_tone_beside_features_in_single_precision(
    recording: Recording, whole: tuple[Array, list[float]], in_pieces: None
) -> None:
    assert machine.precision(6000) is np.float32
    (hum,) = hums(*_humming(recording), TRUNK.arm)
    assert [hum.frequency, hum.size, hum.std] == pytest.approx(whole[1], rel=1e-4)


def test_products_are_in_double_precision(in_pieces: None) -> None:
    features = np.random.default_rng(2).normal(1.0, 1e-3, size=(5000, 3)).astype(np.float32)
    exact = features.astype(float)
    assert np.abs(along(features, features) / (exact.T @ exact) - 1.0).max() < 1e-12
