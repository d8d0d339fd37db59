"""The dead band grows with the load on the joint."""

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import View
from trunk_ros.parameter import Parameter


class LoadDependentFriction(Effect):
    """w += gain abs(tau), or gain (hypot(tau, knee) - knee) where a pretension hides the sign of the load."""

    id = "load_dependent_friction"
    sizes = ("gain",)
    stage, place, regime = "wire", 100, "reversal"
    begins = True
    view = View("load", along=True)
    signature = "Backlash that is wide where the arm reaches out and narrow where it hangs straight."
    source = (
        "Euler-Eytelwein, T' = T'' exp(mu alpha) (Ciofu & Stan, eq. (1)): "
        "friction in proportion to the tension."
    )
    forms = ("sharp", "rounded")
    refined = ("rounded",)
    parameters = (
        Parameter("gain", "rad/(N*m)", (0.0, 1e3), "half-width per moment of load", typical=3e-3),
        Parameter("knee", "N*m", (0.0, 1e3), "load below which the friction grows more slowly", typical=0.02),
    )
    needs = ("load",)
    confused_with = (
        ("backlash", "reverse in upright and in outstretched postures: a backlash stays the same"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        pull = np.abs(now.load)
        if self.form == "rounded":
            pull = np.hypot(now.load, self["knee"]) - self["knee"]
        core.width = core.width + self["gain"] * pull

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "rounded" else cls.parameters[:1]
