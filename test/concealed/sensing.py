"""From the true motion to what is recorded: rates, phases, noise, quantisation, losses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from test.concealed.nominal import COUNT, COUNTS_PER_REV, RATIO, STEP, Array
from test.concealed.plant import Motion
from test.concealed.servo import SUB

Topic: TypeAlias = dict[str, NDArray[Any]]
BASE = 1_750_000_000 * 10**9
PERIOD = SUB * STEP


@dataclass(frozen=True)
class Sensing:
    """How a recording is made: noise in rad rms, colour as AR(1) pole, phase in 2 ms, every 4th is 25 Hz."""

    noise: float = 1e-4
    colour: float = 0.0
    phase: int = 0
    joint_every: int = 1
    gearbox_every: int = 1
    bursts: int = 0
    effort: bool = True
    tip: bool = False
    joint_counts: int = 0
    clock_ppm: float = 0.0
    tip_noise_m: float = 3e-5
    tip_noise_rad: float = 2e-4


@dataclass(frozen=True)
class Run:
    """One recording in memory. Topic: stamp (n,) int64 ns, position (n, 5), velocity, effort; pose (n, 7).

    ``theta_clean`` (n, 5) rad: what an ideal sensor would have shown at the stamps of joint_states.
    """

    kind: str
    topics: dict[str, Topic]
    theta_clean: Array


def _noise(rng: np.random.Generator, shape: tuple[int, int], rms: float, colour: float) -> Array:
    white = rng.normal(size=(shape[0] + 200, shape[1]))
    out: Array = rms * np.sqrt(1 - colour**2) * lfilter([1.0], [1.0, -colour], white, axis=0)[200:]
    return out


def _quantised(angle: Array, counts: int) -> Array:
    step = 2 * np.pi / counts
    return np.round(angle / step) * step


def _stamps(index: NDArray[np.int64], ppm: float = 0.0) -> NDArray[np.int64]:
    nanoseconds = index * round(STEP * 1e9)
    return BASE + nanoseconds + np.round(nanoseconds * ppm * 1e-6).astype(np.int64)


def _kept(rng: np.random.Generator, n: int, bursts: int) -> NDArray[np.bool_]:
    """Messages that arrive: all but some bursts of up to 1.5 s, never the first second."""
    kept = np.ones(n, dtype=bool)
    for _ in range(bursts):
        first = int(rng.integers(n // 50, n))
        kept[first : first + max(1, int(n / 60 * rng.uniform(0.05, 1.5)))] = False
    return kept


def _gearbox(rng: np.random.Generator, motion: Motion, index: NDArray[np.int64], effort: bool) -> Topic:
    v, shape = motion.v[index], (index.size, COUNT)
    torque = 0.01 * np.sign(v) - RATIO * motion.tau[index] + rng.normal(0, 2e-4, shape)
    return {
        "stamp": _stamps(index),
        "position": _quantised(motion.phi[index], COUNTS_PER_REV),
        "velocity": v + rng.normal(0, 1e-3, shape),
        "effort": torque if effort else np.zeros((index.size, 0)),
    }


def _pose(rng: np.random.Generator, motion: Motion, index: NDArray[np.int64], how: Sensing) -> Topic:
    rms = np.array([how.tip_noise_m, how.tip_noise_m, how.tip_noise_rad])
    place = motion.tip[index] + rms * rng.normal(size=(index.size, 3))
    half, zero = place[:, 2] / 2, np.zeros(index.size)
    pose = [zero, place[:, 0], place[:, 1], np.sin(half), zero, zero, np.cos(half)]
    return {"stamp": _stamps(index), "pose": np.stack(pose, axis=1)}


def _asked(index: NDArray[np.int64], position: Array) -> Topic:
    empty = np.zeros((index.size, 0))
    return {"stamp": _stamps(index), "position": position, "velocity": empty, "effort": empty}


def _cut(topic: Topic, kept: NDArray[np.bool_]) -> Topic:
    return {key: value[kept] for key, value in topic.items()}


def record(rng: np.random.Generator, kind: str, reference: Array, setpoint: Array, motion: Motion,
           how: Sensing) -> Run:  # fmt: skip
    """The recording of a motion: reference and setpoint (n, 5) at 100 Hz."""
    tick = np.arange(len(setpoint), dtype=np.int64) * SUB
    joint_index = tick[:: how.joint_every] + how.phase
    clean = motion.theta[joint_index]
    angle = clean + _noise(rng, clean.shape, how.noise, how.colour)
    joint = _asked(joint_index, _quantised(angle, how.joint_counts) if how.joint_counts else angle)
    joint["stamp"] = _stamps(joint_index, how.clock_ppm)
    topics = {
        "reference": _asked(tick, reference),
        "setpoints": _asked(tick, setpoint),
        "gearbox_states": _gearbox(rng, motion, tick[:: how.gearbox_every], how.effort),
        "joint_states": joint,
    }
    if how.tip:
        topics["tip_pose"] = _pose(rng, motion, tick[::2], how)
    kept = {name: _kept(rng, len(topic["stamp"]), how.bursts) for name, topic in topics.items()}
    topics = {name: _cut(topic, kept[name]) for name, topic in topics.items()}
    return Run(kind, topics, clean[kept["joint_states"]])


def draw_sensing(rng: np.random.Generator, hard: bool, tip: bool) -> Sensing:
    """An everyday recording, or one with several of the hard knobs turned."""
    phase = int(rng.integers(1, 5)) if rng.uniform() < 0.4 else 0
    how = Sensing(float(rng.uniform(0.6e-4, 1.5e-4)), phase=phase, effort=bool(rng.uniform() < 0.5), tip=tip)
    if not hard:
        return how
    turned = rng.uniform(size=6) < [0.5, 0.3, 0.15, 0.5, 0.25, 0.15]
    return replace(
        how,
        colour=float(rng.uniform(0.5, 0.95)) if turned[0] else 0.0,
        joint_every=4 if turned[1] else 1,
        gearbox_every=4 if turned[2] else 1,
        bursts=int(rng.integers(2, 9)) if turned[3] else 0,
        joint_counts=int(2 ** rng.integers(16, 19)) if turned[4] else 0,
        clock_ppm=float(rng.uniform(-2, 2)) if turned[5] else 0.0,
    )
