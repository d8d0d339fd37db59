"""The dead band of a joint is narrower than the model says."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class NarrowBand(Effect):
    """w -= less w_nominal."""

    id = "narrow_band"
    sizes = ("less",)
    stage, place, regime = "wire", 100, "reversal"
    begins = True
    signature = (
        "A square wave against the sign of the motion: the joint follows sooner than the model has it."
    )
    source = "Ciofu & Stan, eq. (6)-(8): the deflection is linear in the wire's tension and its friction."
    parameters = (
        Parameter("less", "1", (0.0, 1.0), "share of the nominal dead band that is not there", typical=0.2),
    )
    needs = ("dead_band",)
    confused_with = (("tension_error", "compare joints: a tension error scales the nominal backlash of all"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.width = core.width - self["less"] * core.nominal_width
