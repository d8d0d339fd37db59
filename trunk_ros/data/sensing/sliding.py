"""A servo's own loop that slides past that of its setpoints: each waits until the servo looks next, from none
to a whole period, over and over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.optimize import minimize

from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array, compiled
from trunk_ros.data.align import SETTLING
from trunk_ros.data.sensing.physics import CLOCKED, MOVES, take_off
from trunk_ros.data.spectrum import FINER
from trunk_ros.derivatives import gradient
from trunk_ros.guards import ROUNDED
from trunk_ros.heap import give_back
from trunk_ros.levels import MOST, PART, REFITTED, ROWS, SLIGHT, TENFOLD
from trunk_ros.machine import pieces, precision
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.fill import fill
from trunk_ros.servo_course import servo_course

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


def sliding(setpoints: JointSeries, gearbox: JointSeries, model: ArmModel) -> Sliding | None:
    """How long setpoints wait, where that is a saw with teeth of their period; series with the same joints.

    It is told from how far the gearbox is from the nominal servo's course, over the speed, on all joints at
    once, less what is constant and what a servo of other bandwidth, under load or at its top speed does.
    """
    if min(len(setpoints.stamp), len(gearbox.stamp)) < CLOCKED:
        return None
    period = float(np.median(np.diff(setpoints.stamp)))
    late = _late(setpoints, gearbox, model)
    if late is None or late.able < (PART * period) ** 2 * late.weight.sum():
        return None

    def left(found: Sliding) -> float:
        """Squares of what the servo's own course leaves."""
        there = _late(waited(setpoints, found), gearbox, model)
        return np.inf if there is None else float(np.sum(there.off**2))

    tried = _over_all(late, period)
    if not tried:
        return None
    found = _nearest(min(tried, key=left), left, late.stamp)
    there = _late(waited(setpoints, found), gearbox, model)
    return found if there is not None and there.able < MOST * late.able else None


def _nearest(found: Sliding, left: Callable[[Sliding], float], stamp: Array) -> Sliding:
    """The saw beside one that leaves least of the servo's own course; of long recordings it is told as well
    as that from the lags alone.
    """
    if len(stamp) > TENFOLD * ROWS:
        return found
    length = float(np.ptp(stamp))

    def moved(x: Array) -> Sliding:
        return replace(found, takes=1.0 / (1.0 / found.takes + float(x[0]) / length), phase=float(x[1]))

    first, step = np.array([0.0, found.phase]), 1.0 / (FINER * PHASES)
    simplex = first + step * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    options = {"initial_simplex": simplex, "xatol": SLIGHT * step, "fatol": np.inf}
    return moved(minimize(lambda x: left(moved(x)), first, method="Nelder-Mead", options=options).x)


def waited(setpoints: JointSeries, found: Sliding) -> JointSeries:
    """Setpoints with the stamps at which they acted, but for the mean wait: that is a delay of the servo."""
    return setpoints.restamped(setpoints.stamp + found.waits(setpoints.stamp) - found.longest / 2)


def _saw(stamp: Array, takes: float, phase: float) -> Array:
    """(n,) from 0 to 1, over and over."""
    turns = stamp / takes + phase
    return np.asarray(turns - np.floor(turns))


def _shown(stamp: Array, takes: float, phase: float, follows: float) -> Array:
    """(n,) what a shaft shows of it that ``follows`` some time [s] later: teeth that are rounded."""
    return _rounded(_saw(stamp, takes, phase), follows / takes)


def _rounded(saw: Array, lag: float) -> Array:
    """(n,) of a saw (n,) after a lag of the first order, in teeth; negative for a saw that falls."""
    if lag == 0.0:
        return saw
    if lag < 0.0:
        return np.asarray(1.0 - _rounded(1.0 - saw, -lag))
    return np.asarray(saw - lag + np.exp(-saw / lag) / -np.expm1(-1.0 / lag))


@dataclass(frozen=True)
class _Lags:
    """(n, joints): speed, and what of a servo's errors is off but for what is ``made`` of each joint, an
    orthonormal basis (n, k): what a constant lag, other gains, load and a top speed make of it. That is only
    asked for where a saw is looked for.
    """

    stamp: Array
    speed: Array
    off: Array
    follows: float
    """s after a setpoint has acted, the shaft shows it."""
    made: Callable[[], Iterator[Array]]

    @cached_property
    def along(self) -> Array:
        """(n, all joints' k) speed times the bases: what lags share with these was taken off before."""
        return np.hstack(
            [speed[:, None] * basis for speed, basis in zip(self.speed.T, self.made(), strict=True)]
        )

    @cached_property
    def moment(self) -> Array:
        """(n,) rad²/s; its sum over a time, over that of ``weight``, is the lag in it."""
        return -_products(self.off, self.speed)

    @cached_property
    def weight(self) -> Array:
        """(n,) speed²."""
        return _products(self.speed, self.speed)

    @property
    def able(self) -> float:
        """Power that lags of any kind could explain."""
        return float(np.sum(self.moment**2 / np.maximum(self.weight, ROUNDED)))

    def rows(self, kept: np.ndarray | slice) -> _Lags:
        """Some of them."""
        return _Lags(
            self.stamp[kept],
            self.speed[kept],
            self.off[kept],
            self.follows,
            lambda: (basis[kept] for basis in self.made()),
        )

    def within(self, bins: np.ndarray, many: int) -> tuple[Array, Array]:
        """Of lags that are constant within bins (n,) of the samples: what they share with the moment (many,),
        and their squares (many, many).
        """
        sums = np.zeros((many, 2 + self.along.shape[1]))
        _summed(bins, self.moment, self.weight, self.along, sums)
        return sums[:, 0], np.diag(sums[:, 1]) - sums[:, 2:] @ sums[:, 2:].T

    def powers(self, saws: Array) -> tuple[Array, Array]:
        """What lags (m, n) explain at their best sizes (m,), and these; 0 where that is none."""
        top = saws @ self.moment
        square = (saws**2) @ self.weight - np.sum((saws @ self.along) ** 2, axis=1)
        some = (top > 0.0) & (square > 0.0)
        size = np.divide(top, square, out=np.zeros_like(top), where=some)
        return top * size, size


def _products(one: Array, other: Array) -> Array:
    """(n,) sums of products over the joints, of (n, joints) each."""
    return np.concatenate([np.sum(one[k] * other[k], axis=1) for k in pieces(len(one))])


@compiled
def _summed(bins: np.ndarray, moment: Array, weight: Array, along: Array, sums: Array) -> None:
    for k in range(len(bins)):
        row = sums[bins[k]]
        row[0] += moment[k]
        row[1] += weight[k]
        for other in range(along.shape[1]):
            row[2 + other] += along[k, other]


def _late(setpoints: JointSeries, gearbox: JointSeries, model: ArmModel) -> _Lags | None:
    """How late the gearbox is behind the nominal servo's course."""
    course = servo_course(setpoints, gearbox.stamp, model)
    give_back()
    begins = int(np.searchsorted(course.stamp, course.stamp[0] + SETTLING, side="right"))
    stamp, said = course.stamp[begins:], course.position[begins:]
    if len(stamp) < CLOCKED or not len(moving := np.flatnonzero(np.ptp(said, axis=0) > MOVES)):
        return None
    at, readings = np.searchsorted(gearbox.stamp, stamp), fill(gearbox.position)
    arm = model.only(setpoints.joints).arm
    load = arm.load(said * arm.ratio) if arm.has_load else np.sin(said)
    speed = np.column_stack([gradient(said[:, joint], stamp) for joint in moving])
    pairs = [(speed[:, k], said[:, joint], load[:, joint]) for k, joint in enumerate(moving)]
    off, mixes = np.empty_like(speed), []
    for left, joint, pair in zip(off.T, moving, pairs, strict=True):
        left[:] = readings[at, joint] - said[:, joint]
        mixes.append(take_off(_ways(stamp, *pair), left))
    made = [partial(_ways, stamp, *pair) for pair in pairs]
    return _Lags(
        stamp,
        speed,
        off,
        float(np.mean(1.0 / arm.kp + arm.tau_v)),
        lambda: (design() @ mix for design, mix in zip(made, mixes, strict=True)),
    )


def _ways(stamp: Array, speed: Array, said: Array, load: Array) -> Array:
    """(n, k) what a constant lag, other gains, load and a top speed make of a servo."""
    acts, out = gradient(speed, stamp), np.empty((len(stamp), 9), precision(len(stamp)))
    out[:, 0], out[:, 1], out[:, 2], out[:, 3] = 1.0, speed, acts, gradient(acts, stamp)
    out[:, 4], out[:, 5], out[:, 6] = np.abs(speed) * speed, said, load
    out[:, 7], out[:, 8] = gradient(load, stamp), np.sign(speed)
    return out


def _likeliest(late: _Lags) -> list[Sliding]:
    """The best of all saws by a search over how long one tooth takes, which is too coarse to tell the best of
    them.
    """
    length = np.ptp(late.stamp)
    rates = np.arange(length / SLIDES[1], length / SLIDES[0], 1.0 / FINER) / length
    found = [one for rate in rates for one in _fitted(late, 1.0 / rate)]
    out: list[Sliding] = []
    for _, saw in sorted(found, key=lambda one: -one[0]):
        apart = all(abs(1.0 / saw.takes - 1.0 / other.takes) * length > 1.0 for other in out)
        out += [saw] if apart and len(out) < REFITTED else []
    return out


def _fitted(late: _Lags, takes: float) -> Iterator[tuple[float, Sliding]]:
    """Power that a saw of this length explains that rises, and one that falls, at its best phase, and it."""
    bins = np.minimum(_saw(late.stamp, takes, 0.0) * PHASES, PHASES - 1).astype(int)
    moment, square = late.within(bins, PHASES)
    phases = np.add.outer(np.arange(PHASES), np.arange(PHASES) + 0.5) % PHASES / PHASES
    for length in (takes, -takes):
        saws = _rounded(phases, late.follows / length)
        top, power = saws @ moment, np.sum((saws @ square) * saws, axis=1)
        size = np.divide(top, power, out=np.zeros(PHASES), where=(top > 0.0) & (power > 0.0))
        best = int(np.argmax(top * size))
        yield float(top[best] * size[best]), Sliding(length, best / PHASES, float(size[best]))
        moment, square = moment[::-1], square[::-1, ::-1]  # of a tooth that falls


def _over_all(late: _Lags, period: float) -> list[Sliding]:
    """The likeliest saws of a whole recording: searched for at its beginning, then followed further and
    further.
    """
    stamp = late.stamp
    end, found = min(SLIDES[1], float(np.ptp(stamp))), None
    while True:
        seen = stamp <= stamp[0] + end
        some = late.rows(seen)
        found = _likeliest(some) if found is None else found
        some = some.rows(slice(None, None, max(len(some.stamp) // ROWS, 1)))
        finer = [_finer(some, saw, period) for saw in found]
        found = [saw for saw in finer if saw is not None]
        if not found or seen.all():
            return found
        end *= 2.0


def _finer(late: _Lags, start: Sliding, period: float) -> Sliding | None:
    """The saw at its finest length and phase, where it is as high as a period and explains what there is."""
    near = 1.0 / start.takes + np.linspace(-1.0, 1.0, 41) / (FINER * np.ptp(late.stamp))
    phases = start.phase + np.linspace(-1.5, 1.5, 25) / PHASES
    best = (-np.inf, 0.0, 0.0, 0.0)
    for rate in near:
        saws = np.array([_shown(late.stamp, 1.0 / rate, phase, late.follows) for phase in phases])
        powers, sizes = late.powers(saws)
        k = int(np.argmax(powers))
        best = max(best, (float(powers[k]), float(sizes[k]), 1.0 / rate, phases[k]))
    power, size, takes, phase = best
    if abs(size - period) > (1.0 - MOST) * period or power < MOST * late.able:
        return None
    return Sliding(float(takes), float(phase), period)
