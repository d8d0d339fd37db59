"""Noise is told from what a law is off by where joints rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from test.diagnosis.arms import SHORT, diagnose
from trunk_ros.compiled import Array
from trunk_ros.data.align import wire_span
from trunk_ros.data.noise import Noise
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.at_rest import honest
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.recording.recording import JointSeries, Recording

WHITE, WANDERS = 1e-4, 3e-4  # rad
CORRELATION = 0.95
PERIOD = 0.01  # s


def _recorded(stops: bool) -> Recording:
    """Joints that go for 2 s and rest for 2 s, with readings that wander; where they stop, only as long as
    their motor moves.
    """
    rng, stamp = np.random.default_rng(4), np.arange(0.0, 120.0, PERIOD)
    phase = stamp % 4.0
    goes = phase < 2.0
    way = np.where(goes, phase / 2.0 - np.sin(np.pi * phase) / (2.0 * np.pi), 1.0)
    stations = rng.uniform(-0.5, 0.5, (32, 3))
    at = (stamp // 4.0).astype(int)
    motor = stations[at] + way[:, None] * (stations[at + 1] - stations[at])
    joint = SharpPlay().run(motor, SHORT.arm.dead_band[None], None, SHORT.arm.ratio)[0]
    shown = joint + WHITE * rng.standard_normal(joint.shape) + _wandering(rng, len(stamp), goes, stops)
    series = {
        "gearbox_states": JointSeries(stamp, SHORT.arm.joints, motor),
        "joint_states": JointSeries(stamp, SHORT.arm.joints, shown),
    }
    return Recording("stations", 0, float(stamp[-1]), series)


def _wandering(rng: np.random.Generator, many: int, goes: np.ndarray, stops: bool) -> Array:
    out, now = np.zeros((many, 3)), np.zeros(3)
    for k in range(many):
        if goes[k] or not stops:
            now = CORRELATION * now + WANDERS * np.sqrt(1.0 - CORRELATION**2) * rng.standard_normal(3)
        out[k] = now
    return out


def _context(stops: bool) -> Context:
    """With the noise that the readings look like."""
    context = first_look(WireStage([wire_span(_recorded(stops), SHORT)], SHORT))
    noise = Noise(float(np.hypot(WHITE, WANDERS)), CORRELATION, WHITE)
    return replace(context, noise=(noise,) * 3)


def test_what_wanders_at_rest_as_well_is_noise() -> None:
    context = _context(stops=False)
    assert honest(context, context.known).noise == context.noise


def test_what_stands_still_with_its_joint_is_no_noise() -> None:
    context = _context(stops=True)
    for noise in honest(context, context.known).noise:
        assert (noise.std, noise.remembers) == (pytest.approx(WHITE, rel=0.2), 0.0)


@pytest.mark.long
def test_a_law_that_is_off_in_motion_alone_is_said_to_be_unexplained() -> None:
    result = diagnose(_recorded(stops=True), SHORT)
    assert result.verdict in ("unexplained", "partly_explained")
    for told in result.stages["wire"]["joints"].values():
        assert told["noise_floor"] == pytest.approx(WHITE, rel=0.2)
