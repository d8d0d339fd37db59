"""Past some load one wire of the pair is slack."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, DAMPING, PAYLOAD
from trunk_ros.effects.wire.on_both_sides import HELD, UPSTREAM
from trunk_ros.effects.wire.sagging import Sagging, bend
from trunk_ros.parameter import Parameter

SOFT = Parameter(
    "softness", "N*m", (1e-4, 1e3), "moment within which it goes slack", typical=5e-3, null=5e-3, scale="log",
    scan=(2e-3, 8e-3),
)  # fmt: skip


class WireSlack(Sagging):
    """theta += compliance (tau + sign(tau) excess(abs(tau))): past the threshold one wire carries alone.

    sharp: excess = max(0, abs(tau) - threshold). smooth: the same bent within ``softness``, as softness
    log(1 + exp((abs(tau) - threshold)/softness)) less its value at no load: parts of a wire go slack one
    after another. held: sharp, before the friction, and links with masses swing on the pair.
    """

    id = "wire_slack"
    signature = "The joint sags under weight, and more steeply past a certain load."
    source = (
        "Antagonistic pair with pretension: "
        "stiffness 2k with both wires taut, k with one slack (Kobayashi et al. 1998)."
    )
    forms = ("sharp", "smooth", HELD)
    refined = ("smooth", HELD)
    parameters = (
        bend("threshold", "moment at which one wire goes slack", 0.05),
        COMPLIANCE,
        SOFT,
        PAYLOAD,
        UPSTREAM,
        DAMPING,
    )
    bent = ("threshold", "softness")
    levels = (0.3, 0.55, 0.8)
    confused_with = (
        ("wire_stiffening", "load further: a slack wire softens, a stiffening one hardens"),
        ("load_elasticity", "load beyond the threshold"),
    )

    def drawn(self, load: Array) -> Array:
        threshold = self["threshold"]
        if self.form == "smooth":
            return load + smooth_excess(load, threshold, self["softness"])
        return np.asarray(load + np.sign(load) * np.maximum(np.abs(load) - threshold, 0.0))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        without = {"sharp": (SOFT, DAMPING), "smooth": (DAMPING,), HELD: (SOFT, UPSTREAM)}[form or "sharp"]
        return tuple(p for p in cls.parameters if p not in without)


def smooth_excess(load: Array, threshold: Array, soft: Array) -> Array:
    """Of a ``load`` (n, columns) what lies beyond a ``threshold``, as its sign says, bent within ``soft``
    (columns,) N m each.
    """
    excess = softplus((np.abs(load) - threshold) / soft)
    excess -= softplus(-threshold / soft)
    excess *= soft
    return np.copysign(excess, load)


def softplus(x: Array) -> Array:
    """log(1 + exp(x)): numpy takes several values at once, and half the time of a compiled loop."""
    out = np.abs(x)
    np.log1p(np.exp(np.negative(out, out=out), out=out), out=out)
    out += np.maximum(x, 0.0)
    return out
