"""The drive takes no setpoint above a limit of its own."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter

FREE = 1e4  # rad: no limit, also where a drum turns many times
STANDS = (1.0, 0.99, 0.9)  # quantiles of where a shaft was on that side: most of them where it stood
NEAR = 0.01  # of a shaft's way: a slow loop comes so near to its limit


class SetpointCeiling(Effect):
    """setpoint = min(setpoint, upper), the feedforward's as well."""

    id = "setpoint_ceiling"
    stage, place, regime = "servo", 100, "posture"
    scalable = False
    clips = 1
    signature = "Above one angle the gearbox stays where it is while its setpoint goes on."
    source = "Software position limits of drives, such as object 0x607D of CiA 402."
    parameters = (
        Parameter("upper", "rad", (-FREE, FREE), "largest setpoint that is taken", typical=0.01, null=FREE),
    )
    compensable = False
    confused_with = (
        ("velocity_saturation", "move slowly to and fro there: what is too slow comes after, a limit never"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.highest = np.minimum(core.highest, self["upper"])

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Within where the shaft went: a limit that it never came to is a guess."""
        low, high = now.gearbox.min(), now.gearbox.max()
        return bool(np.all((low < self["upper"]) & (self["upper"] < high + NEAR * (high - low))))

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        return tuple(np.quantile(now.gearbox[:, column], STANDS).tolist())
