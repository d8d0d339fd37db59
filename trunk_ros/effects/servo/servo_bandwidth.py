"""The position loop is slower or faster than nominal."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class ServoBandwidth(Effect):
    """Kp (1 + relative)."""

    id = "servo_bandwidth"
    sizes = ("relative",)
    stage, place, regime = "servo", 100, "high_speed"
    signature = "The gearbox lags the setpoint in proportion to speed, more or less than nominal."
    source = "Position loop with gain Kp: velocity lag v/Kp."
    parameters = (
        Parameter(
            "relative",
            "1",
            (-0.95, 9.0),
            "relative error of the position gain",
            typical=0.1,
            shared=True,
            relative=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = begins = True
    changes = "kp"
    compensable = False
    imitated_by = ("thinned", "wandering_latency")
    confused_with = (
        ("servo_delay", "step the setpoint: a delay does nothing at first, a slow loop starts at once"),
    )

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return number * (1.0 + np.asarray(values.get("relative", 0.0), dtype=float))

    def adjust(self, core: Core, now: Now) -> None:
        core.kp = core.kp * (1.0 + self["relative"])
