"""What a wide loop does before its first turn is fitted where nothing later shows it."""

from __future__ import annotations

import numpy as np
import pytest

from test.diagnosis.arms import diagnose
from trunk_ros.data.align import wire_span
from trunk_ros.data.excerpt import taken
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.time_range import time_range
from trunk_ros.simulate import simulate

DIRECT, NOISE, ONCE = load_model("direct"), 1e-3, "6.3"


def swing() -> Recording:
    """Two swings behind a wide dead band, whose friction goes by the posture, from the middle of the first
    one's way up.
    """
    stamp = np.arange(0.0, 12.6, 0.04)
    motor = np.sin(stamp)
    driven = np.concatenate([np.linspace(0.0, -1.0, 50), np.linspace(-1.0, 0.0, 50), motor])[:, None]
    stuck = SharpPlay().run(driven, np.array([[0.35]]), None)[0]
    joint = (0.8 * stuck + 0.05 * (driven - stuck) * np.sin(2.0 * driven))[-len(stamp) :, 0]
    joint += np.random.default_rng(0).normal(0.0, NOISE, len(stamp))
    series = {
        "gearbox_states": JointSeries(stamp, ("a",), motor[:, None]),
        "joint_states": JointSeries(stamp, ("a",), joint[:, None]),
    }
    return Recording("swing", 0, float(stamp[-1]), series)


def off(recording: Recording, settle: float) -> float:
    """rad, rms of the second swing, by a model of the first one."""
    model = diagnose([recording], model="direct", until=ONCE, settle=settle).model
    shown = recording.series["joint_states"]
    error = simulate(recording, model).series["joint_states"].position - shown.position
    return float(np.sqrt(np.mean(error[shown.stamp > 6.3] ** 2)))


@pytest.mark.long
def test_of_one_swing_the_way_up_before_its_first_turn_is_fitted() -> None:
    assert off(swing(), settle=5.0) < 2.0 * NOISE
    assert off(swing(), settle=0.0) > 10.0 * NOISE


def test_what_is_passed_again_does_not_count_before_the_first_turn() -> None:
    recording = swing()
    once, whole = (wire_span(r, DIRECT) for r in (recording.part(*time_range(12.6, None, ONCE)), recording))
    assert once.early is not None
    assert not (once.early & once.valid).any()
    seen = once.measured(once.gearbox)[once.early]
    assert seen.min() > -0.05  # from its first place upwards
    assert seen.max() > 0.95
    assert whole.early is None
    half = taken(once, once.grid < 3.0, np.zeros(once.gearbox.shape, dtype=bool))
    assert half.early is not None
    assert half.early.sum() == once.early.sum()
