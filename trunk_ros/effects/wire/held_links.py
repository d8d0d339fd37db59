"""Links with masses on their joints' wires, in joints that rub: all of them stick, slip and shake each
other.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled, copied
from trunk_ros.effects.effect import Now
from trunk_ros.effects.filters import rate
from trunk_ros.effects.wire.held_link import held
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.effects.wire.swinging_links import Links, factor, pushed_back, solve

TURN = 0.25  # rad that the fastest joint's swing may go on in a step of the integration
MOST = 16  # steps between two samples
SWEEPS = 200  # over the joints, where the search for who slides comes to no end
OVER = 1e-9  # of the friction: by so much less than it holds, a joint that pulls at it still stands


class HeldLinks:
    """The play with the chain's masses behind it, each on its own wire:

    M(q) y'' + d (y' - u') + k (y - u) = -k w sign(y'), and a joint stays where it stands while what pulls is
    no more than k w.
    """

    def __init__(self, links: Links, now: Now, stiffness: Array | None = None):
        """``stiffness`` (n, columns) N m/rad of wires that bend; otherwise the links'."""
        self.links, self.now, self.stiffness = links, now, stiffness

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.run; state: input, link and its speed (3, columns), and angles, slopes and the last
        step (3, joints) of all joints.
        """
        now, links, swings = self.now, self.links, self.links.omega > 0.0
        if len(u) != len(now.dt):  # places alone, at no time
            out, place = SharpPlay().run(u, width, None if state is None else state[0][1])
            return out, (np.vstack([u[-1], place, 0.0 * place]), None if state is None else state[1])
        angles, places = np.ascontiguousarray(now.angles), np.array(links.columns)[swings]
        own, motion = (np.vstack([u[0], u[0], 0.0 * u[0]]), None) if state is None else state
        first, motion = motion is None, _at_rest(angles) if motion is None else motion.copy()
        out, place = SharpPlay().run(u, width, own[1])
        before, after = own[:, swings], np.vstack([u[-1], place, 0.0 * place])
        moved = np.ascontiguousarray(u[:, swings])
        wide = np.maximum(np.broadcast_to(width, (len(width), len(swings)))[:, swings], 0.0)
        straight = links.arm.straight_inertia[places]
        hold, damp = self._hold(places, swings), 2.0 * links.damping[swings] * links.omega[swings] * straight
        shown = np.empty_like(moved)
        if len(set(places)) == 1:  # alone, or several times so
            make = partial(shaken, now, int(places[0]), motion)
            push, own_mass, motion = now.cached(("shaken", int(places[0])), make) if first else make()
            omega = np.sqrt(hold / own_mass[:, None])
            zeta = damp / (2.0 * own_mass[:, None] * omega)
            held(moved, now.dt, wide, omega, zeta, push[:, None] / hold, before, shown)
        elif len(places):
            mass = np.stack([now.inertia(place) for place in places], axis=1).astype(float)
            hold_links(moved, now.dt, angles, places, mass, hold, damp, wide, before, motion, shown)
        after[:, swings], out[:, swings] = before, shown
        return out, (after, motion)

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.invert, ahead by what moves the masses; the wires' damping is left out, as a dead
        band that is crossed at once would pull at it.
        """
        now, links, swings = self.now, self.links, self.links.omega > 0.0
        places, angles = np.array(links.columns)[swings], np.array(now.angles)
        angles[:, list(links.columns)] = y
        first, second, play = state or (None, None, None)
        speed, first = rate(angles, now.dt, first)
        acceleration, second = rate(speed, now.dt, second)
        ahead, mass = y.copy(), now.masses_at(angles)
        ahead[:, swings] += pushed_back(acceleration, places, mass, self._hold(places, swings))
        u, play = SharpPlay().invert(ahead, width, play)
        return u, (first, second, play)

    def _hold(self, places: np.ndarray, swings: np.ndarray) -> Array:
        """(1 or n, swinging) N m/rad."""
        if self.stiffness is not None:
            return np.ascontiguousarray(self.stiffness[:, swings])
        return np.asarray(self.links.arm.straight_inertia[places] * self.links.omega[swings] ** 2)[None]


def _at_rest(angles: Array) -> Array:
    return np.vstack([angles[0], 0.0 * angles[0], 0.0 * angles[0]])


def shaken(now: Now, place: int, before: Array) -> tuple[Array, Array, Array]:
    """(n,) N m by which the other joints' acceleration moves one, (n,) its own M_jj, and the motion (3,
    joints) of all after it; ``before``: that of the sample before.
    """
    row, motion, push = now.inertia(place), before.copy(), np.empty(len(now.dt))
    shake(np.ascontiguousarray(now.angles), now.dt, place, row, motion, push)
    if len(set(now.columns)) < len(now.joints):  # looked at alone: what the others did is all known
        push[:-1] = (push[:-1] + push[1:]) / 2.0
    return push, np.ascontiguousarray(row[:, place]), motion


@compiled
def shake(angles: Array, dt: Array, place: int, row: Array, motion: Array, push: Array) -> None:
    """``push`` (n,) N m by which the other joints' acceleration moves one; ``row`` (n, joints): that of the
    joint in M.
    """
    joints = angles.shape[1]
    for i in range(len(dt)):
        push[i] = push[i - 1] if i else 0.0
        if dt[i] > 0.0:
            push[i] = 0.0
            for k in range(joints):
                slope = (angles[i, k] - motion[0, k]) / dt[i]
                if k != place:
                    push[i] -= row[i, k] * 2.0 * (slope - motion[1, k]) / (dt[i] + motion[2, k])
                motion[1, k], motion[2, k] = slope, dt[i]
        copied(angles[i], motion[0])


@compiled
def hold_links(
    x: Array, dt: Array, angles: Array, places: np.ndarray, mass: Array, hold: Array, damp: Array,
    width: Array, before: Array, motion: Array, out: Array,
) -> None:  # fmt: skip
    """Joints behind wires at ``x`` (n, swinging); ``hold`` (1 or n, swinging) and ``damp`` (swinging,): their
    stiffness [N m/rad] and damping; ``width`` (1 or n, swinging) rad that they need to slide.

    ``angles`` (n, joints): as those that do not swing move, they push; ``mass`` (n, swinging, joints): rows
    of M. ``before`` (3, swinging) and ``motion`` (3, joints) as above. The rule of the middle, in which
    friction acts by the speed at the end of a step (Moreau 1988): stable whatever the masses. Of what swings
    faster than a step shows all acts by the end of it: by the middle it would never come to rest.
    """
    joints, m = angles.shape[1], len(places)
    stride, bends = (1 if width.shape[0] > 1 else 0), (1 if hold.shape[0] > 1 else 0)
    fixed = np.ones(joints, dtype=np.bool_)
    fixed[places] = False
    slope, full, matrix = np.empty(joints), np.empty((m, m)), np.empty((m, m))
    push, ramp, least, pull, new = np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    side, late = np.zeros(m), np.zeros(m)
    y, speed = before[1], before[2]
    for i in range(len(x)):
        if dt[i] > 0.0:
            fastest, firm = 0.0, hold[i * bends]
            for a in range(m):
                fastest = max(fastest, np.sqrt(firm[a] / mass[i, a, places[a]]))
            steps = min(max(int(np.ceil(fastest * dt[i] / TURN)), 1), MOST)
            h = dt[i] / steps
            for k in range(joints):
                slope[k] = (angles[i, k] - motion[0, k]) / dt[i]
            for a in range(m):
                ramp[a] = (x[i, a] - before[0, a]) / dt[i]
                least[a] = h * firm[a] * width[i * stride, a]
                push[a] = h * damp[a] * ramp[a]
                for k in range(joints):
                    if fixed[k]:
                        push[a] -= mass[i, a, k] * (slope[k] - motion[1, k]) / steps
                for b in range(m):
                    full[a, b] = mass[i, a, places[b]]
                late[a] = 0.5 if h * h * firm[a] <= mass[i, a, places[a]] else 1.0
                full[a, a] += late[a] * h * damp[a] + late[a] * late[a] * h * h * firm[a]
                side[a] = np.sign(speed[a])
            for s in range(steps):
                for a in range(m):
                    middle = before[0, a] + ramp[a] * h * (s + late[a])
                    pull[a] = push[a] - h * firm[a] * (y[a] - middle)
                    pull[a] -= h * damp[a] * speed[a] + late[a] * h * h * firm[a] * speed[a]
                    for b in range(m):
                        pull[a] += full[a, b] * speed[b]
                slide(full, pull, least, side, matrix, new)
                for a in range(m):
                    y[a] += h * ((1.0 - late[a]) * speed[a] + late[a] * new[a])
                    speed[a] = new[a]
            for k in range(joints):
                motion[1, k], motion[2, k] = slope[k], dt[i]
        copied(angles[i], motion[0])
        copied(x[i], before[0])
        copied(y, out[i])


@compiled
def slide(full: Array, pull: Array, least: Array, side: Array, matrix: Array, speed: Array) -> None:
    """Speeds (m,) with which ``full`` (m, m) speed + friction = ``pull`` (m,), where friction is ``least``
    (m,) against what slides, and up to that where it stands. ``side`` (m,): to which side each slides, 0
    where it stands; the last step's is where the search begins.
    """
    m = len(pull)
    for _ in range(3 * m):
        for a in range(m):
            for b in range(m):
                matrix[a, b] = full[a, b] if side[a] != 0.0 and side[b] != 0.0 else 0.0
            if side[a] == 0.0:
                matrix[a, a] = 1.0
            speed[a] = pull[a] - side[a] * least[a] if side[a] != 0.0 else 0.0
        factor(matrix, matrix)
        solve(matrix, speed)
        turned = False
        for a in range(m):
            if side[a] * speed[a] < 0.0:
                side[a], turned = 0.0, True
        if turned:
            continue
        worst, most, towards = -1, 1.0 + OVER, 0.0
        for a in range(m):
            if side[a] == 0.0:
                rest = pull[a]
                for b in range(m):
                    rest -= full[a, b] * speed[b]
                if abs(rest) > most * least[a]:
                    worst, most, towards = a, abs(rest) / max(least[a], OVER), np.sign(rest)
        if worst < 0:
            return
        side[worst] = towards
    for _ in range(SWEEPS):  # it went round in a circle: one by one, which never gets worse
        for a in range(m):
            rest = pull[a] + full[a, a] * speed[a]
            for b in range(m):
                rest -= full[a, b] * speed[b]
            speed[a] = np.sign(rest) * max(abs(rest) - least[a], 0.0) / full[a, a]
            side[a] = np.sign(speed[a])
