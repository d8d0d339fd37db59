"""The link swings on the wire's elasticity."""

from functools import cached_property
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import oscillator, rate
from trunk_ros.parameter import Parameter

RIGID = 1e6  # Hz: no swing that a recording could show


class LinkResonance(Effect):
    """theta'' + 2 zeta omega (theta' - b p') + omega^2 (theta - p) = 0.

    absolute: b = 0, the joint is damped against the arm; relative: b = 1, the wire itself damps.
    """

    id = "link_resonance"
    stage, place, regime = "wire", 500, "high_speed"
    scalable = False
    signature = "After fast moves and stops the residual rings at a frequency of its own."
    source = (
        "Spong (1987), J. Dyn. Syst. 109(4): flexible joint, link inertia on the transmission's stiffness."
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
            scan=(0.05, 0.2),
        ),
    )
    forms = ("absolute", "relative")
    confused_with = (("viscous_lag", "stop abruptly: a lag does not ring"),)

    def credible(self, now: Now) -> bool:
        """It rings, and the samples are close enough to show it."""
        step = float(np.median(now.dt[1:])) if len(now.dt) > 1 else 0.0
        return bool(np.all((self["damping"] < 0.4) & (self["frequency"] * step < 1.0)))

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        state = np.vstack([x[0], x[0], np.zeros_like(x[0])]) if state is None else state.copy()
        out = np.empty_like(x)
        oscillator(x, now.dt, self._omega, self["damping"], self.form == "relative", state, out)
        return out, state

    @cached_property
    def _omega(self) -> Array:
        """(columns,) rad/s; 0 where the link is rigid."""
        return np.where(self["frequency"] >= RIGID, 0.0, 2 * np.pi * self["frequency"])

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        first, second = (None, None) if state is None else state
        speed, first = rate(y, now.dt, first)
        acceleration, second = rate(speed, now.dt, second)
        omega = 2 * np.pi * self["frequency"]
        damped = 0.0 if self.form == "relative" else 2 * self["damping"] / omega * speed
        return y + damped + acceleration / omega**2, (first, second)
