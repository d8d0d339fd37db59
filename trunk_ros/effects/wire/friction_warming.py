"""The dead band shrinks in the course of the recording, as grease and wires warm up."""

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.now import View
from trunk_ros.effects.wire.travelled import SPEED, Travelled
from trunk_ros.parameter import Parameter


class FrictionWarming(Travelled):
    """w -= fall (1 - exp(-t/time_constant)), or (heated) fall lowpass(|s'|/speed), which at that speed is the
    same, and is lost again in pauses; w >= 0.
    """

    id = "friction_warming"
    stage, place, regime = "wire", 100, "reversal"
    signature = "A square wave against the sign of the motion that grows with time, and settles."
    source = (
        "Bittencourt & Gunnarsson (2012), J. Dyn. Syst. 134(5): friction of robot joints falls as they warm; "
        "Newton's law of cooling, heat as the power of steady friction."
    )
    forms = ("exponential", "heated")
    refined = ("heated",)
    view = View("time", along=True)
    parameters = (
        Parameter("fall", "rad", (0.0, 1.0), "half-width that is gone in the end", typical=5e-4),
        Parameter(
            "time_constant", "s", (3.0, 3000.0), "time to 63 % of it", typical=30.0,
            null=30.0, scale="log", scan=(10.0, 40.0),
        ),
        SPEED,
    )  # fmt: skip
    imitated_by = ("skew",)
    confused_with = (
        ("narrow_band", "compare the start and the end of a long recording"),
        ("stribeck_friction", "move as fast at the start as at the end"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        if self.form == "heated" and not now.held:
            warm, core.new[self.id] = self.heat(now, core.old.get(self.id))
        else:
            warm = -np.expm1(-now.stamp[:, None] / self["time_constant"])
        core.width = core.width - self["fall"] * warm

    def credible(self, now: Now, beside: bool = False) -> bool:
        """It settles neither at once nor long after the recording: or the band is narrower from the start."""
        return self.settles(now)

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """What shrinks is told by passing one place twice."""
        return () if motion.once else super().forms_shown(motion)

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        fall, time_constant, speed = cls.parameters
        return (fall, time_constant, speed) if form == "heated" else (fall, time_constant)
