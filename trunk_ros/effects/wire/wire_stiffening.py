"""The wire gets stiffer under load."""

from collections.abc import Callable

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, DAMPING, PAYLOAD
from trunk_ros.effects.wire.on_both_sides import HELD, UPSTREAM
from trunk_ros.effects.wire.sagging import Sagging, bend
from trunk_ros.parameter import Parameter

HALVED = 2**0.5 - 1.0  # puts the halved compliance of x/(1 + c x) at x = 1
BENT: dict[str, Callable[[Array], Array]] = {
    "tangent": np.log1p,
    "secant": lambda x: x / (1.0 + HALVED * x),
    "smooth": np.arctan,
    HELD: np.log1p,
}


class WireStiffening(Sagging):
    """theta += compliance M f(tau/M) with a compliance that has halved at the moment M.

    Tangent: f = ln(1 + x); secant: f = x/(1 + 0.414 x); smooth: f = arctan(x), for x >= 0 and odd.
    held: tangent, before the friction, and links with masses swing on the wire.
    """

    id = "wire_stiffening"
    signature = "The joint sags under weight, but less than in proportion."
    source = "Costello, Theory of Wire Rope (1997), ch. 3: strands bed in and stiffen with tension."
    forms = ("tangent", "secant", "smooth", HELD)
    refined = (HELD,)
    parameters = (
        bend("moment", "moment at which the compliance has halved", 0.1),
        COMPLIANCE,
        PAYLOAD,
        UPSTREAM,
        DAMPING,
    )
    bent = ("moment",)
    levels = (0.3, 0.6, 0.9)
    confused_with = (
        ("wire_slack", "load further: a slack wire softens, a stiffening one hardens"),
        ("load_elasticity", "load further: only this one bends over"),
    )

    def drawn(self, load: Array) -> Array:
        bent = BENT[self.form](np.abs(load) / self["moment"])
        return np.asarray(self["moment"] * np.copysign(bent, load))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        without = UPSTREAM if form == HELD else DAMPING
        return tuple(p for p in cls.parameters if p is not without)
