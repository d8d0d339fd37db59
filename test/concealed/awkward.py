"""Sensors, clocks and loggers as one meets them: what they do to a recording that was made well."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from test.concealed.draws import Rng, logarithmic, sign
from test.concealed.nominal import COUNT, STEP, Array
from test.concealed.sensing import BASE, Run, Topic
from test.concealed.servo import SUB

ADDS: dict[str, float] = {"pink": 1.0, "hum": 0.5**0.5, "coarse": 12**-0.5}


@dataclass(frozen=True)
class Awkward:
    """One of KINDS and how much of it: rad rms, ppm, or s, as the kind has it."""

    kind: str
    size: float

    @property
    def adds(self) -> float:
        """Rad rms that it adds to the noise all the time."""
        return self.size * ADDS.get(self.kind, 0.0)


Spoil: TypeAlias = Callable[[Rng, Run, float], Run]


def _joints(run: Run, **values: Array) -> Run:
    return replace(run, topics={**run.topics, "joint_states": {**run.topics["joint_states"], **values}})


def _shown(run: Run, add: Array) -> Run:
    return _joints(run, position=run.topics["joint_states"]["position"] + add)


def _seconds(topic: Topic) -> Array:
    out: Array = (topic["stamp"] - BASE) * 1e-9
    return out


def slow_noise(rng: Rng, n: int, rms: float) -> Array:
    """1/f noise (n, 5) of the given rms about its mean."""
    tones = np.fft.rfft(rng.normal(size=(2 * n, COUNT)), axis=0)
    tones[1:] /= np.sqrt(np.arange(1, len(tones)))[:, None]
    noise = np.fft.irfft(tones, axis=0)[:n]
    noise -= noise.mean(axis=0)
    out: Array = rms * noise / noise.std(axis=0)
    return out


def _pink(rng: Rng, run: Run, size: float) -> Run:
    return _shown(run, slow_noise(rng, len(run.theta_clean), size))


def _hum(rng: Rng, run: Run, size: float) -> Run:
    """Mains at nearly half or the whole of the rate: what is left of it in the samples is a slow wave."""
    mains = 50.0 * (1 + float(logarithmic(rng, 4e-4, 6e-3)) * sign(rng)) * float(rng.choice([1.0, 2.0]))
    t = _seconds(run.topics["joint_states"])
    return _shown(run, size * np.sin(2 * np.pi * (mains * t[:, None] + rng.uniform(size=COUNT))))


def _outliers(rng: Rng, run: Run, size: float) -> Run:
    hit = rng.uniform(size=run.theta_clean.shape) < 0.01
    return _shown(run, hit * rng.uniform(-size, size, hit.shape))


def _speedy(rng: Rng, run: Run, size: float) -> Run:
    """Noise that grows with speed: size rad rms at 1 rad/s."""
    speed = np.gradient(run.theta_clean, _seconds(run.topics["joint_states"]), axis=0)
    return _shown(run, size * np.abs(speed) * rng.normal(size=speed.shape))


def _burst(rng: Rng, run: Run, size: float) -> Run:
    t = _seconds(run.topics["joint_states"])
    begin = float(rng.uniform(0.1, 0.8)) * t[-1]
    during = (t > begin) & (t < begin + 5.0)
    return _shown(run, during[:, None] * size * rng.normal(size=run.theta_clean.shape))


def _skew(rng: Rng, run: Run, size: float) -> Run:
    """The clock of the joints' computer runs fast or slow by size ppm; both began together."""
    stamp = run.topics["joint_states"]["stamp"]
    return _joints(run, stamp=stamp + np.round((stamp - BASE) * size * 1e-6).astype(np.int64))


def _latched(rng: Rng, run: Run, size: float) -> Run:
    """Joints are asked every ``size`` s; what is published in between is the last answer with a new stamp."""
    t = _seconds(run.topics["joint_states"])
    late = float(rng.uniform(0.0, 0.4)) * size
    asked = np.floor((t - late) / size + 1e-9) * size
    held = np.maximum(np.searchsorted(t, asked + 1e-6, side="right") - 1, 0)
    noise = (run.topics["joint_states"]["position"] - run.theta_clean)[held]
    shown = CubicSpline(t, run.theta_clean)(asked)  # straight lines would be a filter of 4 ms
    return replace(_joints(run, position=shown + noise), theta_clean=shown)


def _wrapped(rng: Rng, run: Run, size: float) -> Run:
    """What passes half a turn comes back from the other side."""
    position = run.topics["joint_states"]["position"]
    return _joints(run, position=(position + np.pi) % (2 * np.pi) - np.pi)


def _coarse(rng: Rng, run: Run, size: float) -> Run:
    return _joints(run, position=np.round(run.topics["joint_states"]["position"] / size) * size)


def _cut(topic: Topic, kept: NDArray[np.intp]) -> Topic:
    return {key: value[kept] for key, value in topic.items()}


def _thinned(rng: Rng, run: Run, size: float) -> Run:
    """The logger keeps every fourth setpoint of those that the servo got."""
    topic = run.topics["setpoints"]
    kept = np.arange(int(rng.integers(4)), len(topic["stamp"]), 4)
    return replace(run, topics={**run.topics, "setpoints": _cut(topic, kept)})


def _stations(rng: Rng, run: Run, size: float) -> Run:
    """One row per second, at the end of each stop; joints on a phase of their own keep it."""
    topics, clean = {}, run.theta_clean
    for name, topic in run.topics.items():
        second, at = np.divmod(_seconds(topic), 1.0)
        order = np.flatnonzero((at > 0.9) & (at < 0.99))
        _, first = np.unique(second[order], return_index=True)
        kept = order[first]
        topics[name] = _cut(topic, kept)
        clean = clean[kept] if name == "joint_states" else clean
    return replace(run, topics=topics, theta_clean=clean)


def _as_it_was(rng: Rng, run: Run, size: float) -> Run:
    return run


_SPOIL: dict[str, Spoil] = {
    "pink": _pink, "hum": _hum, "outliers": _outliers, "speedy": _speedy, "burst": _burst, "skew": _skew,
    "latched": _latched, "wrapped": _wrapped, "coarse": _coarse, "thinned": _thinned, "wandering": _as_it_was,
    "stations": _stations,
}  # fmt: skip
KINDS = tuple(_SPOIL)
FINE = 10  # parts of the drives' steps in which setpoints may begin to act
EVERY_RUN = ("latched",)  # what the sensor does to every run; the rest spoils the run that is diagnosed
MOTION = {"wrapped": "turning", "stations": "stations", "coarse": "resting"}
ALLOWED = {"latched": ("sensor_delay",), "wandering": ("servo_delay",)}  # names that are no lie there


def draw_awkward(rng: Rng, kind: str) -> Awkward:
    """A kind at a size that one meets."""
    sizes = {
        "pink": (1e-4, 3e-4), "hum": (1e-4, 3e-4), "outliers": (5e-3, 5e-2), "speedy": (5e-4, 3e-3),
        "burst": (5e-4, 2e-3), "skew": (20.0, 500.0), "latched": (0.02, 0.05),
    }  # fmt: skip
    size = float(logarithmic(rng, *sizes.get(kind, (1.0, 1.0001))))
    if kind == "coarse":
        size = 2 * np.pi / 2**12
    return Awkward(kind, size * sign(rng) if kind == "skew" else size)


def spoiled(rng: Rng, run: Run, how: Awkward) -> Run:
    """The recording as that sensor, clock or logger makes it."""
    return _SPOIL[how.kind](rng, run, how.size)


def acting(rng: Rng, setpoint: Array, wandering: bool) -> Array:
    """Setpoints (5 n, 5) at 2 ms as they act on the drives, from (n, 5) at 10 ms.

    wandering: the drives' own 100 Hz loop slides past that of the setpoints, late by 0 to 10 ms in turn.
    """
    if not wandering:
        return np.repeat(setpoint, SUB, axis=0)
    t = np.arange(len(setpoint) * SUB * FINE) * STEP / FINE
    period = SUB * STEP * (1 + float(rng.uniform(1e-3, 6e-3)) * sign(rng))
    looked = np.floor(t / period) * period  # when the drives last looked
    which = np.minimum((looked / (SUB * STEP) + 1e-9).astype(np.int64), len(setpoint) - 1)
    out: Array = setpoint[which].reshape(-1, FINE, COUNT).mean(axis=1)  # of a change its part
    return out
