"""Past some load one wire of the pair is slack."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, PAYLOAD
from trunk_ros.parameter import Parameter


class WireSlack(Effect):
    """theta += compliance (tau + sign(tau) max(0, abs(tau) - threshold)): past the threshold one wire
    carries alone.
    """

    id = "wire_slack"
    stage, place, regime = "wire", 200, "posture"
    scalable = False
    signature = "The joint sags under weight, and past some moment more steeply."
    source = (
        "Antagonistic pair with pretension: "
        "stiffness 2k with both wires taut, k with one slack (Kobayashi et al. 1998)."
    )
    parameters = (
        Parameter(
            "threshold",
            "N*m",
            (1e-3, 1e3),
            "moment at which one wire goes slack",
            typical=0.05,
            null=1e3,
            scale="log",
        ),
        COMPLIANCE,
        PAYLOAD,
    )
    needs = ("load",)
    everywhere = True
    replaces = ("load_elasticity",)
    confused_with = (
        ("wire_stiffening", "load further: a slack wire softens, a stiffening one hardens"),
        ("load_elasticity", "load beyond the threshold"),
    )

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._sag(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._sag(now), None

    def _sag(self, now: Now) -> Array:
        excess = np.maximum(np.abs(now.load) - self["threshold"], 0.0)
        return np.asarray(self["compliance"] * (now.load + np.sign(now.load) * excess))

    def grid(self, parameter: Parameter, now: Now, column: int) -> tuple[float, ...]:
        if parameter.name != "threshold":
            return super().grid(parameter, now, column)
        return tuple(max(1.5e-3, q) for q in np.quantile(np.abs(now.load[:, column]), (0.3, 0.55, 0.8)))
