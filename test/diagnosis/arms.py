"""Recordings of arms with known physics, made with the package itself: for what the plants of
test/concealed need not show.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from test.effects.example import arm_of
from trunk_ros import diagnosis
from trunk_ros.chain import Chain
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import JointSeries, Recording

diagnose = partial(diagnosis.diagnose, experiments=False)
"""What is found, without the motions that would tell more: they take up to a third of the time."""

RATE = 100.0
NOISE = 1e-4
TRUNK = load_model("trunk")
SHORT = Model(arm_of(3))
"""An arm like it with three joints, for claims on any arm: it takes half the time."""
PAIR = Model(arm_of(2))
"""For claims on servos: each joint costs as much again."""


def setpoints_of(seconds: float, joints: int, seed: int = 0, rate: float = RATE) -> np.ndarray:
    """(n, joints) gearbox angles: sums of sines with stops."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * rate)) / rate
    out = np.zeros((len(t), joints))
    for j in range(joints):
        for _ in range(4):
            out[:, j] += rng.uniform(0.05, 0.16) * np.sin(
                2 * np.pi * rng.uniform(0.03, 0.5) * t + rng.uniform(0, 6)
            )
    return out


def recorded(
    effects: dict[str, dict[str, Any]] | None = None,
    seconds: float = 25.0,
    seed: int = 0,
    noise: float = NOISE,
    name: str = "made",
    size: float | np.ndarray = 1.0,
    rate: float = RATE,
    nominal: Model = TRUNK,
) -> Recording:
    """Setpoints, gearbox and joints of the ``nominal`` arm with some effects, at a ``rate`` [Hz]; ``size``
    scales the motion, of each joint or of all.
    """
    model = Model(nominal.arm, effects or {})
    joints, stamp = nominal.arm.joints, np.arange(int(seconds * rate)) / rate
    setpoints = size * setpoints_of(seconds, len(joints), seed, rate)
    phi, _ = Chain(model, "servo").run(setpoints, stamp)
    step = 2 * np.pi / nominal.arm.counts_per_rev
    theta, _ = Chain(model, "wire").run(phi, stamp)
    theta = theta + np.random.default_rng(seed + 1).normal(size=theta.shape) * noise
    velocity = np.gradient(phi, stamp, axis=0)
    series = {
        "setpoints": JointSeries(stamp, joints, setpoints),
        "gearbox_states": JointSeries(stamp, joints, np.round(phi / step) * step, velocity),
        "joint_states": JointSeries(stamp, joints, theta),
    }
    return Recording(name, 1_750_000_000_000_000_000, float(stamp[-1]), series)


def on(joint: int, value: float, joints: int = 5) -> np.ndarray:
    """A value on one joint (from 1), nothing on the others."""
    out = np.zeros(joints)
    out[joint - 1] = value
    return out


def reshaped(recording: Recording, key: str, **changes: Any) -> Recording:
    """A recording with one topic changed."""
    return replace(recording, series={**recording.series, key: replace(recording.series[key], **changes)})


def of_joints(recording: Recording, *joints: str) -> Recording:
    """The same of some joints alone, where no other one matters."""
    return replace(recording, series={name: s.select(joints) for name, s in recording.series.items()})


def of_the_wires(recording: Recording) -> Recording:
    """The same without setpoints: servos are not compared, which takes a quarter of the time."""
    return replace(recording, series={k: v for k, v in recording.series.items() if k != "setpoints"})


def of_the_servos(recording: Recording) -> Recording:
    """The same without joint angles: wires are not compared, which takes three quarters of the time."""
    return replace(recording, series={k: v for k, v in recording.series.items() if k != "joint_states"})
