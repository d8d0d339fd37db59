"""The dead band grows in the course of the recording."""

import numpy as np

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter


class FrictionWear(Effect):
    """w += rate t, or rate T (1 - exp(-t/T)) for surfaces that run in."""

    id = "friction_wear"
    stage, place, regime = "wire", 100, "reversal"
    signature = "A square wave with the sign of the motion that grows with time."
    source = (
        "Archard (1953), J. Appl. Phys. 24(8): wear in proportion to the sliding path; here per unit of time."
    )
    forms = ("straight", "running_in")
    refined = ("running_in",)
    parameters = (
        Parameter("rate", "rad/s", (0.0, 0.01), "growth of the half-width at the start", typical=1e-5),
        Parameter(
            "time_constant", "s", (3.0, 3000.0), "time in which it settles", typical=30.0,
            null=3000.0, scale="log", scan=(10.0, 40.0),
        ),
    )  # fmt: skip
    confused_with = (("backlash", "compare the start and the end of a long recording"),)

    def adjust(self, core: Core, now: Now) -> None:
        t = now.stamp[:, None]
        if self.form == "running_in":
            t = -self["time_constant"] * np.expm1(-t / self["time_constant"])
        core.width = core.width + self["rate"] * t

    def credible(self, now: Now) -> bool:
        """It settles neither at once nor after the recording: or it is another effect, or straight."""
        share = self["time_constant"] / (now.stamp[-1] - now.stamp[0])
        return bool(self.form == "straight" or np.all((share > 0.08) & (share < 3.0)))

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "running_in" else cls.parameters[:1]
