"""The dead band grows in the course of the recording."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Motion, Now
from trunk_ros.effects.now import View
from trunk_ros.effects.wire.travelled import SPEED, Travelled
from trunk_ros.parameter import Parameter


class FrictionWear(Travelled):
    """w += rate t, or rate T (1 - exp(-t/T)) for surfaces that run in, or rate s/speed with the path s slid
    so far, which at a mean ``speed`` is the same as rate t.
    """

    id = "friction_wear"
    stage, place, regime = "wire", 100, "reversal"
    signature = "A square wave with the sign of the motion that grows with time."
    source = (
        "Archard (1953), J. Appl. Phys. 24(8): wear in proportion to the sliding path; where the motion is "
        "steady, to time."
    )
    forms = ("straight", "running_in", "travel")
    refined = ("running_in", "travel")
    view = View("time", along=True)
    parameters = (
        Parameter("rate", "rad/s", (0.0, 0.01), "growth of the half-width at the start", typical=1e-5),
        Parameter(
            "time_constant", "s", (3.0, 3000.0), "time in which it settles", typical=30.0,
            null=3000.0, scale="log", scan=(10.0, 40.0),
        ),
        SPEED,
    )  # fmt: skip
    imitated_by = ("skew",)
    confused_with = (("backlash", "compare the start and the end of a long recording"),)

    def adjust(self, core: Core, now: Now) -> None:
        t = now.stamp[:, None]
        if self.form == "running_in":
            t = -self["time_constant"] * np.expm1(-t / self["time_constant"])
        elif self.form == "travel" and not now.held:
            t = self._slid(core, now) / self["speed"]
        core.width = core.width + self["rate"] * t

    def _slid(self, core: Core, now: Now) -> Array:
        """(n, columns) rad gone to and fro since the first sample."""
        gone = now.travelled(core.old.get(self.id))
        core.new[self.id] = gone[-1]
        return gone

    def credible(self, now: Now, beside: bool = False) -> bool:
        """It settles neither at once nor after the recording: or it is another effect, or straight."""
        return self.form != "running_in" or self.settles(now)

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """What grows is told by passing one place twice."""
        return () if motion.once else super().forms_shown(motion)

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        rate, time_constant, speed = cls.parameters
        return {"running_in": (rate, time_constant), "travel": (rate, speed)}.get(form, (rate,))
