"""Links bend under what they carry, beyond the joint's sensor."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class LinkCompliance(Effect):
    """The tip is where joints at theta + compliance tau would have it; no joint sensor shows that."""

    id = "link_compliance"
    stage, place, regime = "arm", 140, "posture"
    signature = "The tip hangs lower the farther the arm reaches out, with the joints where they should be."
    source = "Khalil & Besnard (2002), J. Robot. Autom. 18(1): flexibility in geometric calibration."
    parameters = (
        Parameter("compliance", "rad/(N*m)", (0.0, 1e3), "turn about the joint per moment", typical=0.01),
    )
    needs = ("weight",)
    confused_with = (("joint_zero_error", "reach out and fold: a zero does not follow the load"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.bent = core.bent + self["compliance"] * now.load
