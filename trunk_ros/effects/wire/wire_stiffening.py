"""The wire gets stiffer under load."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, PAYLOAD
from trunk_ros.parameter import Parameter

HALVED = 2**0.5 - 1.0  # puts the halved compliance of x/(1 + c x) at x = 1


class WireStiffening(Effect):
    """theta += compliance M f(tau/M) with a compliance that has halved at the moment M.

    Tangent: f = ln(1 + x); secant: f = x/(1 + 0.414 x); smooth: f = arctan(x), for x >= 0 and odd.
    """

    id = "wire_stiffening"
    stage, place, regime = "wire", 200, "posture"
    scalable = False
    signature = "The joint sags under weight, but less than in proportion."
    source = "Costello, Theory of Wire Rope (1997), ch. 3: strands bed in and stiffen with tension."
    forms = ("tangent", "secant", "smooth")
    parameters = (
        Parameter(
            "moment",
            "N*m",
            (1e-3, 1e3),
            "moment at which the compliance has halved",
            typical=0.1,
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
        ("wire_slack", "load further: a slack wire softens, a stiffening one hardens"),
        ("load_elasticity", "load further: only this one bends over"),
    )

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._sag(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._sag(now), None

    def _sag(self, now: Now) -> Array:
        x = np.abs(now.load) / self["moment"]
        bent = {"tangent": np.log1p(x), "secant": x / (1.0 + HALVED * x), "smooth": np.arctan(x)}[self.form]
        return np.asarray(self["compliance"] * self["moment"] * np.sign(now.load) * bent)

    def grid(self, parameter: Parameter, now: Now, column: int) -> tuple[float, ...]:
        if parameter.name != "moment":
            return super().grid(parameter, now, column)
        return tuple(max(1.5e-3, q) for q in np.quantile(np.abs(now.load[:, column]), (0.3, 0.6, 0.9)))
