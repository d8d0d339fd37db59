"""An added dead band at reversal, whatever the load, speed or amplitude."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class Backlash(Effect):
    """w += half_width."""

    id = "backlash"
    sizes = ("half_width",)
    stage, place, regime = "wire", 100, "reversal"
    begins = True
    signature = (
        "The residual is a square wave with the sign of the motion, the same at every speed and posture."
    )
    source = "Nordin & Gutman (2002), Automatica 38(10): backlash as a play operator, eq. (1)."
    parameters = (
        Parameter(
            "half_width",
            "rad",
            (0.0, 1e3),
            "added half-width of the dead band",
            typical=3e-4,
            scan=(3e-4, 3e-3),
        ),
    )
    imitated_by = ("steps",)
    confused_with = (
        ("tension_error", "compare joints: a tension error scales the nominal backlash of all"),
        ("presliding_hysteresis", "reverse with small amplitudes: backlash lets nothing through"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.width = core.width + self["half_width"]
