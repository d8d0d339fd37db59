"""The dead band grows with the load on the joint."""

import numpy as np

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter


class LoadDependentFriction(Effect):
    """w += gain abs(tau)."""

    id = "load_dependent_friction"
    stage, place, regime = "wire", 100, "reversal"
    signature = "A dead band that is wide where the arm reaches out and narrow where it hangs straight."
    source = (
        "Euler-Eytelwein, T' = T'' exp(mu alpha) (Ciofu & Stan, eq. (1)): "
        "friction in proportion to the tension."
    )
    parameters = (Parameter("gain", "rad/(N*m)", (0.0, 5.0), "half-width per moment of load", typical=3e-3),)
    needs = ("load",)
    confused_with = (
        ("backlash", "reverse in upright and in outstretched postures: a backlash stays the same"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.width = core.width + self["gain"] * np.abs(now.load)
