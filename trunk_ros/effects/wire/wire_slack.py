"""Past some load one wire of the pair is slack."""

import numpy as np
from scipy.special import expit

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Now
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, PAYLOAD
from trunk_ros.effects.wire.on_both_sides import UPSTREAM
from trunk_ros.effects.wire.sagging import Sagging, bend
from trunk_ros.parameter import Parameter

KNEE = 0.03  # of the threshold: within that a sharp one goes slack, for the dead band
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

    def softening(self, now: Now) -> Array:
        within = self["softness"] if self.form == "smooth" else KNEE * self["threshold"]
        return np.asarray(1.0 + expit((np.abs(now.load) - self["threshold"]) / within))

    def sag(self, now: Now) -> Array:
        load, threshold = np.abs(now.load), self["threshold"]
        if self.form == "smooth":
            soft = self["softness"]
            excess = soft * (
                np.logaddexp(0.0, (load - threshold) / soft) - np.logaddexp(0.0, -threshold / soft)
            )
        else:
            excess = np.maximum(load - threshold, 0.0)
        return np.asarray(self["compliance"] * (now.load + np.sign(now.load) * excess))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return tuple(p for p in cls.parameters if form == "smooth" or p is not SOFT)
