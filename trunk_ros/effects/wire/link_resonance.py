"""The link swings on the wire's elasticity."""

from __future__ import annotations

from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Motion, Now
from trunk_ros.effects.filters import oscillator, rate
from trunk_ros.effects.now import View
from trunk_ros.effects.periods import periods
from trunk_ros.effects.swing import Swings, seen_again, stops
from trunk_ros.effects.wire.elements import beside
from trunk_ros.effects.wire.held_link import HeldLink
from trunk_ros.effects.wire.swinging_links import RIGID, Links
from trunk_ros.parameter import Parameter

LEAST_SWINGS, FASTEST = 4.0, 25.0  # in a recording; Hz: of a beam
MOST = 2.0
"""Times the swing of its mass that a beam shows, at most, with room: where its base turns, the tip of an even
one swings 1.14 times as far as it is sent and turns 1.57 times as far; with the mass near the base it swings
1.5 times as far."""
UNDONE = 0.95
"""Of the swing: what undoes more grows without end, as a tip that swings further sets out the other way."""


class LinkResonance(Effect):
    """theta'' + 2 zeta omega (theta' - b p') + omega^2 (theta - p) = 0.

    absolute: b = 0, the joint is damped against the arm; relative: b = 1, the wire itself damps;
    beam: b = 0, and the sensor shows p + share (theta - p), more than all of it at a tip beyond most of the
    mass;
    links: b = 1, with the mass matrix M(q) of the chain: M_jj theta'' + sum M_jk theta_k'' in the place of
    M_jj theta'', so that the other joints' motion shakes the link too. ``frequency`` is that of the
    straight arm;
    held: b = 1, and the friction of the joint, the wire's dead band w, acts on the link itself: it adds
    omega^2 w sign(theta'), and a link that comes to stand sticks.
    """

    id = "link_resonance"
    stage, place, regime = "wire", 500, "high_speed"
    scalable = False
    view = View("time", window=3.0)
    signature = "After fast moves and stops the residual rings at a frequency of its own."
    source = (
        "Spong (1987), J. Dyn. Syst. 109(4): flexible joint, link inertia on the transmission's stiffness; "
        "links: M(q) of the whole chain, as there in eq. (5); held: Coulomb's friction at the link, "
        "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30(7), sect. 5."
    )
    parameters = (
        Parameter(
            "frequency",
            "Hz",
            (0.2, RIGID),
            "natural frequency",
            typical=6.0,
            null=RIGID,
            scale="log",
            scan=tuple(np.geomspace(1.0, 25.0, 14).tolist()),
        ),
        Parameter(
            "damping",
            "1",
            (0.002, 0.95),
            "damping ratio",
            typical=0.1,
            null=0.1,
            scale="log",
        ),
        Parameter(
            "share",
            "1",
            (-3.0, MOST),
            "of the swing that is seen, where the link itself bends; below 0 if it is counted the other way",
            typical=0.5,
            null=0.5,
            scan=(0.9, 0.5, -0.5, -1.0),
        ),
    )
    forms = ("absolute", "relative", "beam", "links", "held")
    shaking = ("links",)
    dear = MappingProxyType({"links": 2, "held": 2})
    imitated_by = ("repeats",)
    confused_with = (
        ("viscous_lag", "stop abruptly: a lag does not ring"),
        ("sensor_delay", "stop abruptly: a delay does not ring"),
        ("unknown_cycle", "stand still: a resonance dies out, what shakes the arm goes on"),
    )

    def credible(self, now: Now, beside: bool = False) -> bool:
        """It rings, where the arm damps it: a link that does not is one that lags. A wire that damps lets the
        link overshoot however strongly it does. And the samples are close enough to show it.
        """
        step = float(np.median(now.dt[1:])) if len(now.dt) > 1 else 0.0
        rings = (self["damping"] < 0.4) | (self.form not in ("absolute", "beam"))
        return bool(np.all(rings & (self["frequency"] * step < 1.0)))

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        forms = super().forms_shown(motion)
        return forms if motion.masses else tuple(form for form in forms if form != "links")

    @property
    def acts_at(self) -> int:
        return self.CORE if self.form == "held" else self.place

    def adjust(self, core: Core, now: Now) -> None:
        link = HeldLink(self._omega, self["damping"], now.dt)
        core.rounding = beside(core.rounding, link, self._omega > 0.0)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        arm = Links.arm_of(self, now)
        if arm is not None:
            return Links(arm, now.columns, self._omega, self["damping"]).run(x, now, state)
        state = np.vstack([x[0], x[0], np.zeros_like(x[0])]) if state is None else state.copy()
        out = np.empty_like(x)
        oscillator(x, now.dt, self._omega, self["damping"], self.form in ("relative", "links"), state, out)
        return x + self["share"] * (out - x) if self.form == "beam" else out, state

    def transients(self, now: Now) -> Swings | None:
        if self._omega[0] == 0.0:
            return None
        arm = Links.arm_of(self, now)
        if arm is not None:
            return Links(arm, now.columns, self._omega, self["damping"]).freed(now)
        moments = seen_again(now.unseen, float(self._omega[0]))
        if self.form == "beam":
            moments = np.union1d(moments, stops(now.stamp, np.ascontiguousarray(now.gearbox[:, 0])))
        omega, zeta = (np.full(len(moments), one[0]) for one in (self._omega, self["damping"]))
        return Swings(moments, omega, zeta) if len(moments) else None

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """A beam rings long, whether its motor stands or not: only the lines of what is left are near enough
        to its frequency.
        """
        if self.form != "beam" or parameter.name == "share":
            return super().grid(parameter, now, column, rest)
        if rest is None:
            return ()
        if parameter.name == "damping":
            return 0.01, 0.05
        least = LEAST_SWINGS / float(now.stamp[-1] - now.stamp[0])
        return tuple(
            c / (2 * np.pi) for c in periods(now.stamp, rest, 2 * np.pi * least, 2 * np.pi * FASTEST)
        )

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "beam" else cls.parameters[:2]

    @cached_property
    def _omega(self) -> Array:
        """(columns,) rad/s; 0 where the link is rigid."""
        return np.where(self["frequency"] >= RIGID, 0.0, 2 * np.pi * self["frequency"])

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        if self.form == "beam":
            return self._straightened(y, now, state)
        arm = Links.arm_of(self, now)
        if arm is not None:
            return Links(arm, now.columns, self._omega, self["damping"]).invert(y, now, state)
        first, second = (None, None) if state is None else state
        speed, first = rate(y, now.dt, first)
        acceleration, second = rate(speed, now.dt, second)
        omega = 2 * np.pi * self["frequency"]
        damped = 2 * self["damping"] / omega * speed if self.form == "absolute" else 0.0
        return y + damped + acceleration / omega**2, (first, second)

    def _straightened(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        """p = (y - share swing(y))/(1 - share), a swing that is faster by the root of 1 - share. Of large
        shares no more than can be undone: the ringing goes all the same.
        """
        share = np.minimum(self["share"], UNDONE)
        rest = 1.0 - share
        state = np.vstack([y[0], y[0], np.zeros_like(y[0])]) if state is None else state.copy()
        out = np.empty_like(y)
        oscillator(y, now.dt, self._omega / np.sqrt(rest), self["damping"] * np.sqrt(rest), False, state, out)
        rigid = self._omega == 0.0
        return np.where(rigid, y, (y - share * out) / rest), state
