"""A pair of wires as friction element, forward and backward."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.wire.play import JITTER
from trunk_ros.effects.wire.profile import pair_step

FIRST = 1e-4  # rad: first stride of a search
REACHED = 1e-11  # rad
TRIES = 80


class WirePair:
    """A friction element whose memory is the tensions of two wires; without pretension it is the play."""

    def __init__(self, tension: Array, radius: float, soft: Array, grip: Array, nominal: Array, load: Array):
        self.tension, self.radius, self.soft, self.grip = tension, radius, soft, grip
        self.nominal, self.load = nominal, load

    def run(self, u: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.run; state: places of wheel and joint (2, columns), tensions, slack."""
        place, tension, slack = self._memory(u, state)
        out = np.empty_like(u)
        run_pair(
            u,
            self._before(width),
            self.load / self.radius,
            self.radius,
            self.soft,
            self.grip,
            place,
            tension,
            slack,
            out,
        )
        return out, (place, tension, slack)

    def invert(self, y: Array, width: Array, state: Any) -> tuple[Array, Any]:
        """As SharpPlay.invert, by a search: the joint goes where the wheel goes."""
        before, u = (None, y[0].copy()) if state is None else (state[0], state[1].copy())
        place, tension, slack = self._memory(y, before)
        out = np.empty_like(y)
        force = self.load / self.radius
        invert_pair(
            y, self._before(width), force, self.radius, self.soft, self.grip, place, tension, slack, u, out
        )
        return out, ((place, tension, slack), u)

    def _before(self, width: Array) -> Array:
        """The dead band in front of the pair: what effects add to the nominal one."""
        return np.asarray(width - np.where(self.tension > 0.0, self.nominal, 0.0))

    def _memory(self, u: Array, state: Any) -> tuple[Array, Array, Array]:
        if state is not None:
            place, tension, slack = state
            return place.copy(), tension.copy(), slack.copy()
        columns, stretches = self.soft.shape
        tension = np.broadcast_to(self.tension[:, None, None], (columns, 2, stretches)).copy()
        return np.stack([u[0], u[0]]), tension, np.zeros((columns, 2))


@compiled
def run_pair(
    u: Array,
    width: Array,
    force: Array,
    radius: float,
    soft: Array,
    grip: Array,
    place: Array,
    tension: Array,
    slack: Array,
    out: Array,
) -> None:
    """Pass ``u`` (n, columns) rad through a play of ``width`` (1 or n, columns) and the pair.

    ``force`` (n, columns) N is what the load pulls with at the joint's radius; the memory changes in place.
    """
    steps, columns = u.shape
    stride = 1 if width.shape[0] > 1 else 0
    for j in range(columns):
        for k in range(steps):
            w = max(width[k * stride, j], 0.0)
            out[k, j] = step(
                u[k, j], w, force[k, j], radius, place[:, j], tension[j], slack[j], soft[j], grip[j]
            )


@compiled
def step(
    u: float,
    w: float,
    force: float,
    radius: float,
    place: Array,
    tension: Array,
    slack: Array,
    soft: Array,
    grip: Array,
) -> float:
    """One step of one column; ``place`` (2,) is the wheel behind the play, and the joint, rad."""
    wheel = min(max(place[0], u - w), u + w)
    if tension[0, 0] + tension[1, 0] + slack[0] + slack[1] > 0.0:
        place[1] += pair_step(radius * (wheel - place[0]), force, tension, slack, soft, grip) / radius
    else:
        place[1] = wheel
    place[0] = wheel
    return float(place[1])


@compiled
def invert_pair(
    y: Array,
    width: Array,
    force: Array,
    radius: float,
    soft: Array,
    grip: Array,
    place: Array,
    tension: Array,
    slack: Array,
    u: Array,
    out: Array,
) -> None:
    """The input of least motion that takes the joint to ``y`` (n, columns) at each step."""
    steps, columns = y.shape
    stride = 1 if width.shape[0] > 1 else 0
    for j in range(columns):
        for k in range(steps):
            w = max(width[k * stride, j], 0.0)
            u[j] = seek(
                y[k, j], u[j], w, force[k, j], radius, place[:, j], tension[j], slack[j], soft[j], grip[j]
            )
            step(u[j], w, force[k, j], radius, place[:, j], tension[j], slack[j], soft[j], grip[j])
            out[k, j] = u[j]


@compiled
def seek(
    y: float,
    u: float,
    w: float,
    force: float,
    radius: float,
    place: Array,
    tension: Array,
    slack: Array,
    soft: Array,
    grip: Array,
) -> float:
    """The input next to ``u`` at which the joint is at ``y``: false position, halved (Illinois).

    The memory stays as it is.
    """
    gap = y - step(u, w, force, radius, place.copy(), tension.copy(), slack.copy(), soft, grip)
    if abs(gap) <= JITTER:
        return u
    side = 1.0 if gap > 0.0 else -1.0
    near, short, far, over = u, -abs(gap), u, -1.0
    stride = abs(gap) + 2.0 * w + FIRST
    last = 0
    for count in range(TRIES):
        if over < 0.0:
            middle = far + side * stride
            stride *= 2.0
        else:
            middle = 0.5 * (near + far) if count % 4 == 3 else (near * over - far * short) / (over - short)
        off = side * (
            step(middle, w, force, radius, place.copy(), tension.copy(), slack.copy(), soft, grip) - y
        )
        if abs(off) < REACHED:
            return middle
        if over < 0.0:
            far, over = middle, off
            if off < 0.0:
                near, short = middle, off
        elif off < 0.0:
            near, short, over, last = middle, off, over * (0.5 if last < 0 else 1.0), -1
        else:
            far, over, short, last = middle, off, short * (0.5 if last > 0 else 1.0), 1
    return far
