"""Past some load one wire of the pair is slack."""

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, DAMPING, PAYLOAD
from trunk_ros.effects.wire.on_both_sides import UPSTREAM
from trunk_ros.effects.wire.sagging import HELD, Sagging, bend
from trunk_ros.parameter import Parameter

FAR = 40.0  # exp(-FAR) is rounding beside 1
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
    signature = "The joint sags under weight, and past some moment more steeply."
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
    levels = (0.3, 0.55, 0.8)
    confused_with = (
        ("wire_stiffening", "load further: a slack wire softens, a stiffening one hardens"),
        ("load_elasticity", "load beyond the threshold"),
    )

    def sag(self, load: Array) -> Array:
        threshold = self["threshold"]
        if self.form == "smooth":
            excess = np.empty_like(load)
            smooth_excess(load, threshold, self["softness"], excess)
        else:
            excess = np.sign(load) * np.maximum(np.abs(load) - threshold, 0.0)
        return np.asarray(self["compliance"] * (load + excess))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        without = {"sharp": (SOFT, DAMPING), "smooth": (DAMPING,), HELD: (SOFT, UPSTREAM)}[form or "sharp"]
        return tuple(p for p in cls.parameters if p not in without)


@compiled
def smooth_excess(load: Array, threshold: Array, soft: Array, out: Array) -> None:
    """Of a ``load`` (n, columns) what lies beyond a ``threshold``, as its sign says, bent within ``soft``
    (columns,) N m each.
    """
    for j in range(load.shape[1]):
        none = softplus(-threshold[j] / soft[j])
        for k in range(len(load)):
            size = soft[j] * (softplus((abs(load[k, j]) - threshold[j]) / soft[j]) - none)
            out[k, j] = size if load[k, j] > 0.0 else -size if load[k, j] < 0.0 else 0.0


@compiled
def softplus(x: float) -> float:
    """log(1 + exp(x)); FAR from 0 the rest is rounding."""
    bent: float = max(x, 0.0) + (np.log1p(np.exp(-abs(x))) if abs(x) < FAR else 0.0)
    return bent
