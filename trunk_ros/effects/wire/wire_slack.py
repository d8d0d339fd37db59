"""Past some load one wire of the pair is slack."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, PAYLOAD
from trunk_ros.effects.wire.on_both_sides import UPSTREAM
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
    after another.
    """

    id = "wire_slack"
    signature = "The joint sags under weight, and past some moment more steeply."
    source = (
        "Antagonistic pair with pretension: "
        "stiffness 2k with both wires taut, k with one slack (Kobayashi et al. 1998)."
    )
    forms = ("sharp", "smooth")
    refined = ("smooth",)
    parameters = (
        bend("threshold", "moment at which one wire goes slack", 0.05),
        COMPLIANCE,
        SOFT,
        PAYLOAD,
        UPSTREAM,
    )
    levels = (0.3, 0.55, 0.8)
    confused_with = (
        ("wire_stiffening", "load further: a slack wire softens, a stiffening one hardens"),
        ("load_elasticity", "load beyond the threshold"),
    )

    def sag(self, load: Array) -> Array:
        size, threshold = np.abs(load), self["threshold"]
        if self.form == "smooth":
            soft = self["softness"]
            excess = soft * (
                np.logaddexp(0.0, (size - threshold) / soft) - np.logaddexp(0.0, -threshold / soft)
            )
        else:
            excess = np.maximum(size - threshold, 0.0)
        return np.asarray(self["compliance"] * (load + np.sign(load) * excess))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return tuple(p for p in cls.parameters if form == "smooth" or p is not SOFT)
