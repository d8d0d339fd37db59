"""A link with mass on an elastic wire, in a joint that rubs: it sticks and slips."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.filters import rate, swing_step
from trunk_ros.effects.wire.play import SharpPlay

TURN = 0.25  # rad that a swing may go on in a step, within which it is found when it stops
MOST = 64  # steps between two samples
UNSEEN = np.pi  # rad that a swing goes on between samples, from which on they do not show it
SLOWEST = 1e-9  # rad/s: below, the link is rigid


class HeldLink:
    """The play with a link that has mass behind it, damped by its wire:

    y'' + 2 zeta omega (y' - u') + omega^2 (y - u) = -omega^2 w sign(y'), and y stays where it stands while
    what pulls is no more than omega^2 w.
    """

    def __init__(self, omega: Array, zeta: Array, dt: Array):
        """``omega`` rad/s, 0 for a rigid link, ``zeta`` (columns,); ``dt`` (n,) s of the samples."""
        self.omega, self.zeta, self.dt = omega, zeta, dt

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.run; state (3, columns): input, link and its speed."""
        if len(u) != len(self.dt):  # places alone, at no time
            out, place = SharpPlay().run(u, width, None if state is None else state[1])
            return out, np.vstack([u[-1], place, 0.0 * place])
        memory = np.vstack([u[0], u[0], 0.0 * u[0]]) if state is None else state.copy()
        out = np.empty_like(u)
        nothing = np.zeros((1, u.shape[1]))
        held(u, self.dt, np.maximum(width, 0.0), self.omega[None], self.zeta[None], nothing, memory, out)
        return out, memory

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.invert, ahead by what moves the mass: the wire's damping, at which a dead
        band pulls that is crossed at once, is left out.
        """
        first, second, play = state or (None, None, None)
        speed, first = rate(y, self.dt, first)
        acceleration, second = rate(speed, self.dt, second)
        swings, stiff = self.omega >= SLOWEST, np.maximum(self.omega, SLOWEST)
        u, play = SharpPlay().invert(y + np.where(swings, acceleration / stiff**2, 0.0), width, play)
        return u, (first, second, play)


@compiled
def held(
    u: Array, dt: Array, width: Array, omega: Array, zeta: Array, push: Array, memory: Array, out: Array
) -> None:
    """Pass ``u`` (n, columns) through; ``width``, ``omega``, ``zeta`` and ``push``, rad by which a wire would
    be ahead to push the link as something else does, (1 or n, columns); ``memory`` (3, columns) changes in
    place.

    Between samples the input runs straight; sliding one way the link is linear and its step exact. One that
    swings faster than samples show is where its wire lets it be.
    """
    stride, faster_or_slower = (1 if width.shape[0] > 1 else 0), (1 if omega.shape[0] > 1 else 0)
    pushed = 1 if push.shape[0] > 1 else 0
    swing, rest = np.zeros(5), np.zeros(5)
    for j in range(u.shape[1]):
        old, y, speed = memory[0, j], memory[1, j], memory[2, j]
        known, last = -1.0, -1.0
        for k in range(len(u)):
            w, new, ahead = width[k * stride, j], u[k, j], push[k * pushed, j]
            own, damping = omega[k * faster_or_slower, j], zeta[k * faster_or_slower, j]
            if own <= 0.0 or own * dt[k] > UNSEEN:
                before, y = y, min(max(y, new + ahead - w), new + ahead + w)
                speed = (y - before) / dt[k] if dt[k] > 0.0 else 0.0
                old, out[k, j] = new, y
                continue
            if dt[k] <= 0.0:
                old, out[k, j] = new, y
                continue
            steps = min(max(int(np.ceil(own * dt[k] / TURN)), 1), MOST)
            h = dt[k] / steps
            ramp = (new - old) / dt[k]
            lead = 2.0 * damping / own * ramp  # of the damper, which the wire's motion pulls along
            for i in range(steps):
                begin, left, first = old + ahead + ramp * h * i, h, True
                while left > 0.0:
                    if speed == 0.0:
                        pull = begin + ramp * left + lead - y
                        if abs(pull) <= w:
                            break
                        side = 1.0 if pull > 0.0 else -1.0
                    else:
                        side = 1.0 if speed > 0.0 else -1.0
                    part = swing
                    if first and (h != known or own != last):
                        swing_step(h, own, damping, swing)
                        known, last = h, own
                    elif not first:
                        swing_step(left, own, damping, rest)
                        part = rest
                    goal = begin - side * w
                    off, faster = y - goal, speed - ramp
                    there = goal + ramp * left + part[0] * off + part[1] * faster
                    then = ramp + part[2] * off + part[3] * faster
                    if then * side > 0.0:
                        y, speed = there, then
                        break
                    if speed == 0.0 or not first:  # it does not get away, or stops once more
                        speed = 0.0
                        break
                    share = speed / (speed - then)
                    y, speed, first = y + share * (there - y), 0.0, False
                    begin, left = begin + ramp * share * left, (1.0 - share) * left
            old = new
            out[k, j] = y
        memory[0, j], memory[1, j], memory[2, j] = old, y, speed
