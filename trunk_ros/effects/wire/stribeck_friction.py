"""The dead band is wider at low speed."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter


class StribeckFriction(Effect):
    """w += amplitude s(abs(v)/velocity) with s = exp(-x), exp(-x^2) or 1/(1 + x^2)."""

    id = "stribeck_friction"
    stage, place, regime = "wire", 100, "low_speed"
    signature = "Backlash that is wide in slow motion and narrow in fast motion."
    source = (
        "Armstrong-Helouvry, Dupont & Canudas de Wit (1994), Automatica 30(7), eq. (3): "
        "exp(-abs(v/v_s)^delta)."
    )
    forms = ("exponential", "gaussian", "hyperbolic")
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
    )
    confused_with = (("backlash", "reverse slowly and fast: a backlash stays the same"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.width = core.width + self["amplitude"] * self._fade(np.abs(now.speed) / self["velocity"])

    def _fade(self, x: Array) -> Array:
        if self.form == "hyperbolic":
            return 1.0 / (1.0 + x**2)
        return np.asarray(np.exp(-(x**2 if self.form == "gaussian" else x)))
