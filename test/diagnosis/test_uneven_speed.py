"""Servos that are faster one way than the other: cylinders with one rod, motors with advanced timing."""

from __future__ import annotations

import numpy as np
import pytest

from trunk_ros.compiled import Array
from trunk_ros.diagnosis import diagnose
from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.recording.recording import JointSeries, Recording

KP, TOP, DELAY, NOISE, FINE = 12.0, 3.0, 0.03, 1e-3, 1e-3


def _went(stamp: Array, asked: Array, up: float, down: float) -> Array:
    """A loop of first order whose speed is held between -down and up, on steps of 1 ms."""
    fine = np.arange(0.0, stamp[-1] + FINE / 2, FINE)
    held = asked[np.clip(np.searchsorted(stamp, fine - DELAY + 1e-9, side="right") - 1, 0, None)]
    phi, out = 0.0, np.empty(len(fine))
    for k, target in enumerate(held):
        out[k] = phi
        phi += FINE * min(max(KP * (target - phi), -down), up)
    return np.interp(stamp, fine, out)


def _diagnosed(excess: float) -> Answer:
    stamp, rng = np.arange(0.0, 60.0, 0.02), np.random.default_rng(5)
    holds = np.cumsum(rng.uniform(0.1, 1.2, 200))
    asked = np.concatenate([[0.0], rng.uniform(-1.5, 1.5, 200)])[np.searchsorted(holds, stamp)]
    went = _went(stamp, asked, (1.0 + excess) * TOP, (1.0 - excess) * TOP)
    went += NOISE * rng.standard_normal(went.shape)
    series = {
        "setpoints": JointSeries(stamp, ("a",), asked[:, None]),
        "gearbox_states": JointSeries(stamp, ("a",), went[:, None]),
    }
    return diagnose(Recording("servo", 0, 60.0, series), model="direct", experiments=False)


def test_a_servo_that_is_faster_up_than_down_is_named_and_by_how_much() -> None:
    found = [f for f in _diagnosed(0.2).findings if f.effect == "uneven_speed"]
    assert [f.parameters["a"]["excess"]["value"] for f in found] == [pytest.approx(0.2, abs=0.01)]


def test_one_that_is_as_fast_both_ways_is_not() -> None:
    assert not [f for f in _diagnosed(0.0).findings if f.effect == "uneven_speed"]
