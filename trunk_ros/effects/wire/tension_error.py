"""The pull tension is not the nominal one."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class TensionError(Effect):
    """w_i = factor w_i,nominal for all joints: eq. (7) is linear in T_i."""

    id = "tension_error"
    sizes = ("factor",)
    stage, place, regime = "wire", 100, "reversal"
    begins = True
    signature = (
        "Square waves with the sign of the motion on all joints, in proportion to their nominal backlash."
    )
    source = "Ciofu & Stan, eq. (6)-(8): the elongation is proportional to the pull tension T_i."
    parameters = (
        Parameter(
            "factor",
            "1",
            (0.0, 50.0),
            "tension over nominal tension",
            typical=1.2,
            null=1.0,
            shared=True,
            scan=(0.7, 1.4),
        ),
    )
    everywhere = True
    needs = ("dead_band",)
    confused_with = (("backlash", "compare joints: a backlash is not in proportion to the nominal backlash"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.width = core.width + (self["factor"] - 1.0) * core.nominal_width
