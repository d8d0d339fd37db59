"""The wire stretches under the joint's resistance moment."""

from typing import Any

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Now
from trunk_ros.effects.wire.on_both_sides import UPSTREAM, OnBothSides
from trunk_ros.parameter import Parameter

COMPLIANCE = Parameter(
    "compliance", "rad/(N*m)", (0.0, 20.0), "deflection per moment", typical=0.03, stated="compliance"
)
PAYLOAD = Parameter(
    "payload", "kg", (0.0, 2.0), "mass at the tip", typical=0.05, shared=True, optional=True, carried=True
)


class LoadElasticity(OnBothSides):
    """theta += compliance tau."""

    id = "load_elasticity"
    stage, place, regime = "wire", 200, "posture"
    begins = grows = True
    signature = "The joint sags under weight: the residual follows the reach of all that hangs on the joint."
    source = (
        "Hooke: compliance = l_i/(E A_s R_c^2); Ciofu & Stan, sect. 4: "
        "deformation from the resistance moment."
    )
    parameters = (COMPLIANCE, PAYLOAD, UPSTREAM)
    needs = ("load",)
    everywhere = True
    confused_with = (
        ("ratio_error", "move the other joints: a ratio error does not care"),
        ("joint_coupling", "reach the same moment with different joints"),
    )

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self["compliance"] * now.load, None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self["compliance"] * now.load, None
