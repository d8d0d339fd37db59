"""The dead band grows in the course of the recording."""

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter


class FrictionWear(Effect):
    """w += rate t."""

    id = "friction_wear"
    stage, place, regime = "wire", 100, "reversal"
    signature = "A square wave with the sign of the motion that grows with time."
    source = (
        "Archard (1953), J. Appl. Phys. 24(8): wear in proportion to the sliding path; here per unit of time."
    )
    parameters = (Parameter("rate", "rad/s", (0.0, 0.01), "growth of the half-width", typical=1e-5),)
    confused_with = (("backlash", "compare the start and the end of a long recording"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.width = core.width + self["rate"] * now.stamp[:, None]
