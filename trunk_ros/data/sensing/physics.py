"""What physics may do to a joint, roughly: all that a clock must not be taken for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array, compiled
from trunk_ros.data.motion_content import in_its_play
from trunk_ros.derivatives import gradient
from trunk_ros.guards import BLIND, ROUNDED, TINY
from trunk_ros.levels import FAR_OFF, MOST, ROWS
from trunk_ros.machine import pieces, precision
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.resample import SLOW, resample
from trunk_ros.resistance import Resistance, resistance

CREEPS = (2.0, 8.0)  # s
PLAY = 1e-3  # rad, where the model has none
WIDER_PLAYS = (2.5, 6.0)  # times the dead band that the model has
SLOWLY = 0.05  # rad/s, at which friction may have fallen
MOVES = 0.02  # rad
BLOCK = 50  # samples may depend on each other
CLOCKED = 10 * BLOCK  # samples: the scatter of fewer blocks tells nothing of clocks


@dataclass(frozen=True)
class Motion:
    """(n,) s, and (n, joints): where the gearbox would have the joints, their speed, what they show."""

    stamp: Array
    asked: Array
    speed: Array
    shown: Array
    arm: Arm
    resists: Resistance | None = None
    """What the recording tells of the load."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names."""
        return self.arm.joints

    @cached_property
    def moving(self) -> list[int]:
        """Joints that move enough to tell anything."""
        return [int(j) for j in np.flatnonzero(np.ptp(self.asked, axis=0) > MOVES)]

    @cached_property
    def off(self) -> Array:
        """(n, joints) of what they show from where the gearbox would have them."""
        return self.shown - self.asked

    @cached_property
    def load(self) -> Array:
        """(n, joints) N m, zero where the arm has none and none was measured."""
        if self.resists is not None:
            return self.resists.load(self.arm, self.asked)
        return self.arm.load(self.asked) if self.arm.has_load else np.zeros_like(self.asked)

    @cached_property
    def time(self) -> Array:
        """(n,) from 0 to 1."""
        return np.asarray((self.stamp - self.stamp[0]) / max(float(np.ptp(self.stamp)), 1e-9))


def motion_of(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Motion:
    """At the joints' stamps, of series with the same joints."""
    phi, velocity = resample(gearbox, shown.stamp)
    resists, seen = resistance(arm, gearbox, shown.stamp, phi, shown), fill(shown.position)
    ratio = arm.ratio * gains(phi * arm.ratio, seen)
    return Motion(shown.stamp, phi * ratio, velocity * ratio, seen, arm, resists)


def gains(asked: Array, shown: Array) -> Array:
    """(joints,) rad that joints move per rad of (n, joints) where the gearbox should have them, where that is
    far from 1: nobody knew the ratio, and a lag beside a turned sign would be a lead.
    """
    asked, shown = (each - each.mean(axis=0) for each in (asked, shown))
    along, own, other = (np.sum(a * b, axis=0) for a, b in ((asked, shown), (asked, asked), (shown, shown)))
    gain = along / np.maximum(own, TINY)
    told = (np.abs(gain - 1.0) > FAR_OFF) & (along**2 > MOST * own * other)
    return np.where(told, gain, 1.0)


def while_driven(gearbox: JointSeries, shown: JointSeries) -> JointSeries:
    """What joints showed while the gearbox was seen."""
    return shown.rows((shown.stamp >= gearbox.stamp[0]) & (shown.stamp <= gearbox.stamp[-1]))


def tells_of_clocks(shown: JointSeries) -> bool:
    """Whether joints were read enough, and often enough."""
    return len(shown.stamp) >= CLOCKED and float(np.median(np.diff(shown.stamp))) <= SLOW / 2


def some_motion(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> Motion | None:
    """Of so many rows as tell of clocks, where there are any, and some joint moves."""
    if not tells_of_clocks(shown):
        return None
    shown = shown.rows(np.arange(len(shown.stamp)) % max(len(shown.stamp) // ROWS, 1) == 0)
    motion = motion_of(gearbox, shown, arm)
    return motion if motion.moving else None


def beside_physics(motion: Motion, joint: int, *own: Array, wear: bool = True) -> Array:
    """(n, features): such as are (n,) of a clock's ``own``, and after them what physics does to a joint:
    friction (always, by load, at low speed, and ``wear``: that grows), posture, load, coupling, creep, drift
    and inertia.
    """
    return Features.of(motion, joint, *own, wear=wear)[:]


@dataclass(frozen=True)
class Features:
    """The same, made of the few that need all rows (n,) when some rows are asked for: of a long recording all
    of them are as large as all else.
    """

    motion: Motion
    joint: int
    own: tuple[Array, ...]
    wear: bool
    way: Array
    rush: Array
    creeps: tuple[Array, ...]

    @staticmethod
    def of(motion: Motion, joint: int, *own: Array, wear: bool = True) -> Features:
        """Of a joint."""
        asked, stamp = motion.asked[:, joint], motion.stamp
        way = in_its_play(asked, _dead_band(motion, joint))
        creeps = tuple(lowpassed(stamp, asked, late) for late in CREEPS)
        return Features(motion, joint, own, wear, way, gradient(motion.speed[:, joint], stamp), creeps)

    @property
    def shape(self) -> tuple[int, int]:
        """(n, features)."""
        return len(self.way), len(self.own) + 16 + self.wear + 2 * len(self.motion.joints)

    def __len__(self) -> int:
        return len(self.way)

    def __getitem__(self, rows: slice) -> Array:
        out = np.empty((len(self.way[rows]), self.shape[1]), precision(len(self)))
        some = chain((each[rows] for each in self.own), self._made(rows))
        for column, feature in zip(out.T, some, strict=True):
            column[:] = feature
        return out

    def _made(self, rows: slice) -> Iterator[Array]:
        motion, way, asked = self.motion, self.way[rows], self.motion.asked[rows]
        speed, load = motion.speed[rows, self.joint], motion.load[rows, self.joint]
        t, own = motion.time[rows], asked[:, self.joint]
        yield from (way, way * np.abs(load), way * np.exp(-np.abs(speed) / SLOWLY))
        if self.wear:
            yield way * t
        yield from (np.ones_like(t), t, t**2)
        yield from (load, load * np.abs(load), load * t, own**2, own**3, own * t)
        yield from (self.rush[rows], speed**2)
        yield from (creep[rows] for creep in self.creeps)
        yield from np.sin(np.cumsum(asked, axis=1)).T
        yield from asked.T


def wider_plays(motion: Motion, joint: int, wear: bool = True) -> Iterator[Array]:
    """(n,) each: what dead bands make of a joint that are wider than the model's, and ``wear``: that grow."""
    own, dead_band = motion.asked[:, joint], _dead_band(motion, joint)
    for wider in WIDER_PLAYS:
        yield (way := in_its_play(own, wider * dead_band))
        if wear:
            yield way * motion.time


def _dead_band(motion: Motion, joint: int) -> float:
    return float(motion.arm.dead_band[joint]) or PLAY


def along(features: Array | Features, others: Array | Features) -> Array:
    """(k, ...) products of features (n, k) with others (n, ...), in double precision."""
    alike = others is features
    total = np.zeros((features.shape[1], *others.shape[1:]))
    for k in pieces(*features.shape):
        one = features[k].astype(float, copy=False)
        total += one.T @ (one if alike else others[k].astype(float, copy=False))
    return total


def take_off(features: Array | Features, signal: Array) -> Array:
    """Take what features (n, k) say of a ``signal`` (n,) off it; and the mixtures by which they are
    orthonormal.
    """
    mix = apart(features)
    told = mix @ (mix.T @ along(features, signal))
    for rows in pieces(*features.shape):
        signal[rows] -= features[rows] @ told
    return mix


def apart(features: Array | Features) -> Array:
    """(k, fewer): the mixtures of features (n, k) that are orthonormal and say the same."""
    square = along(features, features)
    size = np.sqrt(np.maximum(square.diagonal(), TINY))
    power, mix = np.linalg.eigh(square / np.outer(size, size))
    told = power > BLIND * power[-1]
    return np.asarray(mix[:, told] / np.sqrt(power[told]) / size[:, None])


def scaled(features: Array) -> tuple[Array, Array]:
    """Features (n, k) over their rms (k,), and that; 1 where a feature is nothing."""
    size = np.sqrt(np.mean(features**2, axis=0))
    size = np.where(size > 0.0, size, 1.0)
    return features / size, size


def fitted(features: Array, off: Array) -> tuple[Array, Array]:
    """Shares (features,) of features (n, features) in ``off`` (n,), and their std from blocks of samples, so
    that what is smooth counts once.
    """
    features, size = scaled(features)
    inverse = np.linalg.pinv(features.T @ features, rcond=BLIND, hermitian=True)
    values = inverse @ (features.T @ off)
    left = features * (off - features @ values)[:, None]
    blocks = np.add.reduceat(left, np.arange(0, len(left), BLOCK), axis=0)
    spread = np.sqrt(np.diag(inverse @ (blocks.T @ blocks) @ inverse))
    return values / size, np.maximum(spread / size, ROUNDED)


@compiled
def lowpassed(stamp: Array, own: Array, late: float) -> Array:
    """(n,) rad of (n,) rad behind a lag of first order [s]."""
    out, last = np.empty_like(own), own[0]
    for k in range(len(own)):
        last += (1.0 - np.exp(-(stamp[k] - stamp[max(k - 1, 0)]) / late)) * (own[k] - last)
        out[k] = last
    return out
