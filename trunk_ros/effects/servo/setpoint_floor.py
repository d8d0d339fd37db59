"""The drive takes no setpoint below a limit of its own."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.servo.setpoint_ceiling import FREE, NEAR, STANDS
from trunk_ros.parameter import Parameter


class SetpointFloor(Effect):
    """setpoint = max(setpoint, lower), the feedforward's as well."""

    id = "setpoint_floor"
    stage, place, regime = "servo", 100, "posture"
    scalable = False
    clips = -1
    signature = "Below one angle the gearbox stays where it is while its setpoint goes on."
    source = "Software position limits of drives, such as object 0x607D of CiA 402."
    parameters = (
        Parameter(
            "lower", "rad", (-FREE, FREE), "smallest setpoint that is taken", typical=-0.01, null=-FREE
        ),
    )
    compensable = False
    confused_with = (
        ("velocity_saturation", "move slowly to and fro there: what is too slow comes after, a limit never"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.lowest = np.maximum(core.lowest, self["lower"])

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Within where the shaft went: a limit that it never came to is a guess."""
        low, high = now.gearbox.min(), now.gearbox.max()
        return bool(np.all((low - NEAR * (high - low) < self["lower"]) & (self["lower"] < high)))

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        return tuple(np.quantile(now.gearbox[:, column], 1.0 - np.array(STANDS)).tolist())
