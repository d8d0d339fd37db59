"""Links with masses that swing on their joints' wires, shaken by all other joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array, compiled, copied
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import lowpass, rate, swing_step
from trunk_ros.effects.swing import Swings, seen_again

TURN = 0.1  # rad that the fastest joint's swing may go on in a step of the integration
MOST = 64  # steps of one posture
STIFFEST = 1e-9  # rad/(N m): nothing swings on less
RIGID = 1e6  # Hz: no swing that a recording could show
STANDS = 0.02  # s for which a posture lasts


@dataclass(frozen=True)
class Links:
    """Joints in some ``columns`` of an arm behind wires of their own stiffness."""

    arm: Arm
    columns: tuple[int, ...]
    omega: Array
    """(columns,) rad/s of the straight arm; 0 where a joint is rigid."""
    damping: Array
    """(columns,) damping ratio there."""

    @staticmethod
    def arm_of(e: Effect, now: Now) -> Arm | None:
        """The arm whose links swing; None where the effect's form or the arm knows of no masses."""
        return now.arm if e.form in e.shaking and now.arm is not None and now.arm.has_load else None

    @staticmethod
    def on_wires(e: Effect, now: Now) -> Links | None:
        """Those of an effect with a ``compliance`` and a ``damping``; None likewise."""
        arm = Links.arm_of(e, now)
        if arm is None:
            return None
        soft = e["compliance"]
        own = np.maximum(soft, STIFFEST) * arm.straight_inertia[list(now.columns)]
        return Links(arm, now.columns, np.where(soft > STIFFEST, 1.0 / np.sqrt(own), 0.0), e["damping"])

    def freed(self, now: Now) -> Swings | None:
        """How one of them may swing where nobody saw what set it going: in its posture at that moment."""
        moments = seen_again(now.unseen, float(self.omega[0]))
        if not len(moments):
            return None
        place, rows = self.columns[0], np.searchsorted(now.stamp, moments)
        lighter = np.sqrt(self.arm.straight_inertia[place] / now.inertia(place)[rows, place])
        return Swings(moments, self.omega[0] * lighter, self.damping[0] * lighter)

    def shown(self) -> dict[str, Array]:
        """The swing of each, as ``link_resonance`` has it."""
        frequency = np.where(self.omega > 0.0, self.omega / (2.0 * np.pi), RIGID)
        return {"frequency": frequency, "damping": self.damping}

    @property
    def _places(self) -> np.ndarray:
        return np.array(self.columns)[self.omega > 0.0]

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        """Joint angles behind wires at ``x`` (n, columns), under what all joints' acceleration asks."""
        swings, places, angles = self.omega > 0.0, self._places, now.angles
        begun = state or (np.vstack([x[0], x[0], 0.0 * x[0]]), np.vstack([angles[0], 0.0 * angles[0]]))
        out, own, motion = x.copy(), begun[0].copy(), begun[1].copy()
        before, moved = own[:, swings], np.ascontiguousarray(x[:, swings])
        shown = np.empty_like(moved)
        omega, zeta, straight = self.omega[swings], self.damping[swings], self.arm.straight_inertia[places]
        if len(set(places)) == 1:  # alone, or several times so
            make = partial(pushed, now, places[0], motion)
            push, own_mass, motion = make() if state else now.cached(("pushed", places[0]), make)
            lighter = np.sqrt(straight[0] / own_mass)
            for k, (swing, damping) in enumerate(zip(omega, zeta, strict=True)):
                one = np.ascontiguousarray(moved[:, k])
                swing_link(one, now.dt, push, swing * lighter, damping * lighter, before[:, k], shown[:, k])
        elif len(places):
            angles = np.ascontiguousarray(angles)
            first = now.masses[:1] if state is None else now.masses_at(motion[:1])
            mass = np.concatenate([first, now.masses], dtype=float)
            swing_links(moved, now.dt, angles, places, mass, straight, omega, zeta, before, motion, shown)
        own[:, swings], out[:, swings] = before, shown
        return out, (own, motion)

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        """The wires' angle for joints at ``y``: ahead by what moves the masses, damped as the wires are."""
        swings, places, angles = self.omega > 0.0, self._places, np.array(now.angles)
        angles[:, list(self.columns)] = y
        first, second, lag = (None, None, np.zeros((2, len(places)))) if state is None else state
        speed, first = rate(angles, now.dt, first)
        acceleration, second = rate(speed, now.dt, second)
        omega, lag = self.omega[swings], lag.copy()
        stiffness = self.arm.straight_inertia[places] * omega**2
        push = pushed_back(acceleration, places, now.masses_at(angles), stiffness)
        ahead = np.empty_like(push)
        lowpass(push, now.dt, 2 * self.damping[swings] / omega, lag, ahead)
        out = y.copy()
        out[:, swings] += ahead
        return out, (first, second, lag)


@compiled
def swing_links(
    x: Array, dt: Array, angles: Array, places: np.ndarray, mass: Array, straight: Array, omega: Array,
    zeta: Array, before: Array, motion: Array, out: Array,
) -> None:  # fmt: skip
    """M(q) theta'' + d (theta' - x') + k (theta - x) = 0 for joints that swing behind wires at ``x`` (n,
    swinging), with k = M_jj(0) omega^2 and d = 2 zeta omega M_jj(0).

    ``angles`` (n, joints) of all joints move straight between samples, so that those that do not swing push
    by the changes of their slopes; ``places`` (swinging,): which joints swing. ``mass`` (n + 1, joints,
    joints): M of the sample before the first and of each, ``straight`` (swinging,): M_jj(0). ``before`` (3,
    swinging): x, theta and theta' of the sample before; ``motion`` (2, joints): angles and slopes of it.
    Coriolis' forces are left out. Trapezoidal rule (Newmark 1959, beta = 1/4): stable whatever the masses.
    """
    joints, m = angles.shape[1], len(places)
    row, fixed = np.empty(joints), np.ones(joints, dtype=np.bool_)
    hold, damp = np.empty(m), np.empty(m)
    for a in range(m):  # whole arrays take seconds to compile, for the words of what would not fit
        fixed[places[a]] = False
        hold[a], damp[a] = straight[a] * omega[a] ** 2, 2.0 * straight[a] * zeta[a] * omega[a]
    matrix, light, stiff, yielding = np.empty((m, m)), np.empty((m, m)), np.empty((m, m)), np.empty((m, m))
    slope = np.empty(joints)
    push, ramp, wire, now, new = np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    y, rate = before[1], before[2]
    for i in range(len(x)):
        if dt[i] > 0.0:
            for k in range(joints):
                slope[k] = (angles[i, k] - motion[0, k]) / dt[i]
            for a in range(m):
                ramp[a] = (x[i, a] - before[0, a]) / dt[i]
                wire[a] = before[0, a]
            parts = int(np.ceil(dt[i] / STANDS))
            steps = min(max(int(np.ceil(omega.max() * dt[i] / parts / TURN)), 1), MOST)
            h = dt[i] / (parts * steps)
            for part in range(parts):
                share = (part + 0.5) / parts
                for a in range(m):
                    for k in range(joints):
                        old, later = mass[i, places[a], k], mass[i + 1, places[a], k]
                        row[k] = old + share * (later - old)
                    push[a] = 0.0
                    for b in range(m):
                        matrix[a, b] = stiff[a, b] = row[places[b]]
                    for k in range(joints):
                        if fixed[k]:
                            push[a] -= row[k] * (slope[k] - motion[1, k])
                    stiff[a, a] += h / 2 * damp[a] + h * h / 4 * hold[a]
                factor(matrix, light)
                factor(stiff, stiff)
                invert(stiff, yielding)
                if part == 0:
                    solve(light, push)
                    for a in range(m):
                        rate[a] += push[a]
                for a in range(m):
                    now[a] = -damp[a] * (rate[a] - ramp[a]) - hold[a] * (y[a] - wire[a])
                solve(light, now)
                for _ in range(steps):
                    for a in range(m):
                        wire[a] += ramp[a] * h
                        y[a] += h * rate[a] + h * h / 4 * now[a]
                        rate[a] += h / 2 * now[a]
                        new[a] = -damp[a] * (rate[a] - ramp[a]) - hold[a] * (y[a] - wire[a])
                    for a in range(m):
                        now[a] = 0.0
                        for b in range(m):
                            now[a] += yielding[a, b] * new[b]
                        y[a] += h * h / 4 * now[a]
                        rate[a] += h / 2 * now[a]
            for k in range(joints):
                motion[1, k] = slope[k]
        copied(angles[i], motion[0])
        copied(x[i], before[0])
        copied(y, out[i])


def pushed(now: Now, place: int, before: Array) -> tuple[Array, Array, Array]:
    """(n,) rad/s by which the other joints' changes of speed push one at each sample, (n,) its own M_jj, and
    angles and slopes (2, joints) after it all; ``before``: those of the sample before.
    """
    row, motion, push = now.inertia(place), before.copy(), np.empty(len(now.dt))
    push_link(np.ascontiguousarray(now.angles), now.dt, place, row, motion, push)
    return push, np.ascontiguousarray(row[:, place]), motion


@compiled
def push_link(angles: Array, dt: Array, place: int, row: Array, motion: Array, push: Array) -> None:
    """``row`` (n, joints): that of the joint in M."""
    for i in range(len(dt)):
        push[i] = 0.0
        if dt[i] > 0.0:
            for k in range(angles.shape[1]):
                slope = (angles[i, k] - motion[0, k]) / dt[i]
                if k != place:
                    push[i] -= row[i, k] / row[i, place] * (slope - motion[1, k])
                motion[1, k] = slope
        copied(angles[i], motion[0])


@compiled
def swing_link(
    x: Array, dt: Array, push: Array, omega: Array, zeta: Array, before: Array, out: Array
) -> None:
    """The same of one joint alone, exact for the posture of each sample: ``x`` and ``out`` (n,), ``before``
    (3,); ``push`` (n,) rad/s, ``omega`` (n,) rad/s and ``zeta`` (n,) those of each posture.
    """
    swing = np.zeros(5)
    old, y, rate = before[0], before[1], before[2]
    for i in range(len(x)):
        if dt[i] > 0.0:
            rate += push[i]
            swing_step(dt[i], omega[i], zeta[i], swing)
            ramp = (x[i] - old) / dt[i]
            off, faster = y - old, rate - ramp
            y = x[i] + swing[0] * off + swing[1] * faster
            rate = ramp + swing[2] * off + swing[3] * faster
        old = x[i]
        out[i] = y
    before[0], before[1], before[2] = old, y, rate


@compiled
def factor(matrix: Array, lower: Array) -> None:
    """Cholesky factor (m, m) of a symmetric positive ``matrix``, which it may overwrite."""
    for i in range(len(matrix)):
        for j in range(i + 1):
            rest = matrix[i, j]
            for k in range(j):
                rest -= lower[i, k] * lower[j, k]
            lower[i, j] = np.sqrt(rest) if i == j else rest / lower[j, j]


@compiled
def solve(lower: Array, b: Array) -> None:
    """What the factored matrix makes ``b`` (m,) of, in the place of ``b``."""
    m = len(b)
    for i in range(m):
        for k in range(i):
            b[i] -= lower[i, k] * b[k]
        b[i] /= lower[i, i]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            b[i] -= lower[k, i] * b[k]
        b[i] /= lower[i, i]


@compiled
def invert(lower: Array, out: Array) -> None:
    """The inverse (m, m) of the factored matrix: where it meets many vectors, no division is left."""
    for i in range(len(out)):
        for k in range(len(out)):
            out[i, k] = 1.0 if i == k else 0.0
        solve(lower, out[i])


def pushed_back(acceleration: Array, places: np.ndarray, mass: Array, stiffness: Array) -> Array:
    """How far wires of ``stiffness`` (swinging,) have to be ahead of joints [rad] (n, swinging) for all
    joints to accelerate as told (n, joints), but for the wires' damping; ``mass`` (n, joints, joints): M.
    """
    return np.asarray(np.einsum("njk,nk->nj", mass[:, places], acceleration) / stiffness)
