"""The dead band is wider at low speed."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter

STEP = 0.0025  # s: friction that falls while the joint speeds up lets it leap
MOST = 200  # steps between two samples
FAST = 6.1  # times the speed at which it fades: so little is left that it would be lost in rounding


class StribeckFriction(Effect):
    """w += amplitude s(abs(v)/velocity) with s = exp(-x), exp(-x^2) or 1/(1 + x^2), v the motor's speed;
    film: exp(-x^2) of the joint's own speed, which is not the motor's while the wire winds up, as of late:
    v' = (abs(theta') - v)/memory.
    """

    id = "stribeck_friction"
    stage, place, regime = "wire", 110, "low_speed"  # the last: a film of oil sees the whole width
    signature = "Backlash that is wide in slow motion and narrow in fast motion."
    source = (
        "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30(7), eq. (3): "
        "exp(-abs(v/v_s)^delta); film: the same, eq. (5): frictional memory."
    )
    forms = ("exponential", "gaussian", "hyperbolic", "film")
    parameters = (
        Parameter("amplitude", "rad", (0.0, 1.0), "half-width added at rest", typical=5e-4),
        Parameter(
            "velocity",
            "rad/s",
            (1e-3, 3.0),
            "joint speed at which it fades",
            typical=0.05,
            null=0.05,
            scale="log",
            scan=(0.015, 0.05, 0.15, 0.4),
        ),
        Parameter(
            "memory",
            "s",
            (1e-3, 2.0),
            "time that a film of oil takes",
            typical=0.05,
            null=0.05,
            scale="log",
            scan=(0.05, 0.3),  # from shorter ones a joint chatters, and no small step pays
        ),
    )
    confused_with = (("backlash", "reverse slowly and fast: a backlash stays the same"),)

    @property
    def acts_at(self) -> int:
        return self.CORE

    def adjust(self, core: Core, now: Now) -> None:
        if self.form == "film":
            core.width = core.width + self._of_the_joint(core, now)
        else:
            core.width = core.width + self["amplitude"] * self._fade(np.abs(now.winding) / self["velocity"])

    def _of_the_joint(self, core: Core, now: Now) -> Array:
        """(n, columns) rad that the friction has more, where the joint moves behind its own dead band."""
        u = now.gearbox * now.ratio
        before = core.old.get(self.id)
        memory = np.array([u[0], 0.0 * u[0], u[0]]) if before is None else before.copy()
        out = np.empty_like(u)
        width = np.ascontiguousarray(np.broadcast_to(core.width, u.shape))
        film(u, width, self["amplitude"], self["velocity"], self["memory"], now.dt, memory, out)
        core.new[self.id] = memory
        return out

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "film" else cls.parameters[:2]

    def _fade(self, x: Array) -> Array:
        if self.form == "hyperbolic":
            return 1.0 / (1.0 + x**2)
        return np.asarray(np.exp(-(x**2 if self.form == "gaussian" else x)))


@compiled
def film(
    u: Array,
    width: Array,
    amplitude: Array,
    velocity: Array,
    lag: Array,
    dt: Array,
    memory: Array,
    out: Array,
) -> None:
    """What friction has more (n, columns) rad under wires that move by ``u`` (n, columns) rad; ``memory``
    (3, columns) is the joint's angle, its speed of late, and ``u``.
    """
    steps, columns = u.shape
    for j in range(columns):
        theta, late, last = memory[0, j], memory[1, j], memory[2, j]
        slow, before, follows, per_second = 1.0 / velocity[j], -1.0, 0.0, 0.0
        for k in range(steps):
            parts = min(max(int(np.ceil(dt[k] / STEP - 1e-6)), 1), MOST)
            h = dt[k] / parts
            if h != before:
                before, follows, per_second = h, -np.expm1(-h / lag[j]), 1.0 / h if h > 0.0 else 0.0
            at, step, more = last, (u[k, j] - last) / parts, 0.0
            for _ in range(parts):
                share = late * slow
                more = amplitude[j] * np.exp(-share * share) if share < FAST else 0.0
                w = max(width[k, j] + more, 0.0)
                at += step
                moved = min(max(theta, at - w), at + w)
                late += (abs(moved - theta) * per_second - late) * follows
                theta = moved
            out[k, j], last = more, u[k, j]
        memory[0, j], memory[1, j], memory[2, j] = theta, late, last
