"""Past some load one wire of the pair is slack."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Now
from trunk_ros.effects.wire.load_elasticity import COMPLIANCE, PAYLOAD
from trunk_ros.effects.wire.sagging import Sagging, bend


class WireSlack(Sagging):
    """theta += compliance (tau + sign(tau) max(0, abs(tau) - threshold)): past the threshold one wire
    carries alone.
    """

    id = "wire_slack"
    signature = "The joint sags under weight, and past some moment more steeply."
    source = (
        "Antagonistic pair with pretension: "
        "stiffness 2k with both wires taut, k with one slack (Kobayashi et al. 1998)."
    )
    parameters = (bend("threshold", "moment at which one wire goes slack", 0.05), COMPLIANCE, PAYLOAD)
    levels = (0.3, 0.55, 0.8)
    confused_with = (
        ("wire_stiffening", "load further: a slack wire softens, a stiffening one hardens"),
        ("load_elasticity", "load beyond the threshold"),
    )

    def sag(self, now: Now) -> Array:
        excess = np.maximum(np.abs(now.load) - self["threshold"], 0.0)
        return np.asarray(self["compliance"] * (now.load + np.sign(now.load) * excess))
