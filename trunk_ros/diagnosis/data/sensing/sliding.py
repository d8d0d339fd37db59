"""A servo's own loop that slides past that of its setpoints: each waits until the servo looks next, from none
to a whole period, over and over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.align import SETTLING
from trunk_ros.diagnosis.data.sensing.physics import FEWEST, MOVES, scaled
from trunk_ros.diagnosis.discrepancy.spectrum import FINER
from trunk_ros.diagnosis.levels import MOST, ROWS
from trunk_ros.guards import ROUNDED
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.fill import fill
from trunk_ros.servo_course import servo_course

LEAST = 0.1  # of the setpoints' period: rms of lags that a saw may be in; its own is 0.29
SLIDES = (0.5, 60.0)  # s for one period
PHASES = 16


@dataclass(frozen=True)
class Sliding:
    """Time [s] to slide by one period (negative: waits grow shorter), its phase, and the longest wait [s]."""

    takes: float
    phase: float
    longest: float

    def waits(self, stamp: Array) -> Array:
        """(n,) s that setpoints of these stamps wait."""
        return np.asarray(self.longest * _saw(stamp, self.takes, self.phase))


def sliding(setpoints: JointSeries, gearbox: JointSeries, model: Model) -> Sliding | None:
    """How long setpoints wait, where that is a saw with teeth of their period; series with the same joints.

    It is told from how far the gearbox is from the nominal servo's course, over the speed, on all joints at
    once, less what is constant and what a servo of other bandwidth, under load or at its top speed does.
    """
    if min(len(setpoints.stamp), len(gearbox.stamp)) < FEWEST:
        return None
    period = float(np.median(np.diff(setpoints.stamp)))
    late = _late(setpoints, gearbox, model)
    if late is None:
        return None
    _, moment, weight = late
    if _able(moment, weight) < (LEAST * period) ** 2 * weight.sum():
        return None
    found = _over_all(*late, period)
    if found is None:
        return None
    arm = model.only(setpoints.joints).arm
    follows = 1.0 / arm.kp + arm.tau_v  # s after a setpoint has acted, the shaft shows it
    found = replace(found, phase=found.phase + follows / found.takes)
    left = _late(waited(setpoints, found), gearbox, model)
    return found if left is not None and _able(*left[1:]) < MOST * _able(*late[1:]) else None


def waited(setpoints: JointSeries, found: Sliding) -> JointSeries:
    """Setpoints with the stamps at which they acted, but for the mean wait: that is a delay of the servo."""
    stamp = setpoints.stamp + found.waits(setpoints.stamp) - found.longest / 2
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(stamp)) > 0.0])
    return replace(setpoints.rows(rising), stamp=stamp[rising])


def _saw(stamp: Array, takes: float, phase: float) -> Array:
    """(n,) from 0 to 1, over and over."""
    turns = stamp / takes + phase
    return np.asarray(turns - np.floor(turns))


def _late(setpoints: JointSeries, gearbox: JointSeries, model: Model) -> tuple[Array, Array, Array] | None:
    """Stamps (n,), moments (n,) rad²/s and speed² (n,): their sums' ratio over a time is the lag in it."""
    course = servo_course(setpoints, gearbox.stamp, model)
    kept = course.stamp > course.stamp[0] + SETTLING
    stamp, said = course.stamp[kept], course.position[kept]
    at = np.searchsorted(gearbox.stamp, stamp)
    off = fill(gearbox.position)[at] - said
    moving = np.ptp(said, axis=0) > MOVES
    if len(stamp) < FEWEST or not moving.any():
        return None
    speed = np.gradient(said, stamp, axis=0)[:, moving]
    columns = zip(off.T[moving], speed.T, said.T[moving], strict=True)
    left = np.column_stack([_left(stamp, *column) for column in columns])
    return stamp, -np.sum(left * speed, axis=1), np.sum(speed**2, axis=1)


def _left(stamp: Array, off: Array, speed: Array, said: Array) -> Array:
    """(n,) of what a servo is off, less what a constant lag, other gains, load and a top speed make of it."""
    acts = np.gradient(speed, stamp)
    ways = [np.ones_like(off), speed, acts, np.gradient(acts, stamp), np.abs(speed) * speed, said]
    design, _ = scaled(np.column_stack([*ways, np.sin(said), np.sign(speed)]))
    values, *_ = np.linalg.lstsq(design, off, rcond=1e-9)
    return np.asarray(off - design @ values)


def _likeliest(stamp: Array, moment: Array, weight: Array) -> Sliding:
    """The best of all saws by a search over how long one tooth takes."""
    most = np.ptp(stamp) / SLIDES[0]
    rates = np.arange(np.ptp(stamp) / SLIDES[1], most, 1.0 / FINER) / np.ptp(stamp)
    found = [_fitted(stamp, moment, weight, way / rate) for rate in rates for way in (1.0, -1.0)]
    return max(found, key=lambda one: one[0])[1]


def _fitted(stamp: Array, moment: Array, weight: Array, takes: float) -> tuple[float, Sliding]:
    """Power that a saw of this length explains, at its best phase, and the saw."""
    bins = np.floor(_saw(stamp, takes, 0.0) * PHASES).astype(int)
    late = np.bincount(bins, moment, PHASES)
    heavy = np.bincount(bins, weight, PHASES)
    best = (-np.inf, Sliding(takes, 0.0, 0.0))
    for shift in range(PHASES):
        saw = (np.arange(PHASES) + 0.5 + shift) % PHASES / PHASES
        mean = float(saw @ heavy / heavy.sum())
        top, power = float((saw - mean) @ late), float(((saw - mean) ** 2) @ heavy)
        if top > 0.0 and top**2 / power > best[0]:
            best = (top**2 / power, Sliding(takes, shift / PHASES, top / power))
    return best


def _over_all(stamp: Array, moment: Array, weight: Array, period: float) -> Sliding | None:
    """The saw of a whole recording: searched for at its beginning, then followed further and further."""
    end, found = min(SLIDES[1], float(np.ptp(stamp))), None
    while True:
        seen = stamp <= stamp[0] + end
        some = (stamp[seen], moment[seen], weight[seen])
        found = _finer(*some, _likeliest(*some) if found is None else found, period)
        if found is None or seen.all():
            return found
        end *= 2.0


def _finer(stamp: Array, moment: Array, weight: Array, start: Sliding, period: float) -> Sliding | None:
    """The saw at its finest length and phase, where it is as high as a period and explains what there is."""
    every = max(len(stamp) // ROWS, 1)
    stamp, moment, weight = stamp[::every], moment[::every], weight[::every]
    near = 1.0 / start.takes + np.linspace(-1.0, 1.0, 41) / (FINER * np.ptp(stamp))
    tried = [
        (_power(stamp, moment, weight, 1.0 / rate, phase), 1.0 / rate, phase)
        for rate in near
        for phase in start.phase + np.linspace(-1.5, 1.5, 25) / PHASES
    ]
    (power, size), takes, phase = max(tried, key=lambda one: one[0][0])
    if abs(size - period) > (1.0 - MOST) * period or power < MOST * _able(moment, weight):
        return None
    return Sliding(float(takes), float(phase), period)  # the servo rounds the teeth, which makes them smaller


def _able(moment: Array, weight: Array) -> float:
    """Power that lags of any kind could explain."""
    return float(np.sum(moment**2 / np.maximum(weight, ROUNDED)))


def _power(stamp: Array, moment: Array, weight: Array, takes: float, phase: float) -> tuple[float, float]:
    saw = _saw(stamp, takes, phase)
    saw = saw - float(saw @ weight / weight.sum())
    top, power = float(saw @ moment), float((saw**2) @ weight)
    return (top**2 / power, top / power) if top > 0.0 else (0.0, 0.0)
