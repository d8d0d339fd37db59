"""The servo's velocity loop is slower or faster than nominal."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class VelocityLoop(Effect):
    """tau_v (1 + relative)."""

    id = "velocity_loop"
    sizes = ("relative",)
    stage, place, regime = "servo", 100, "high_speed"
    signature = "The gearbox overshoots after fast moves, or errs in proportion to acceleration."
    source = "Velocity loop as a first-order lag: time constant = motor-side inertia over the loop's damping."
    parameters = (
        Parameter(
            "relative",
            "1",
            (-0.99, 99.0),
            "relative error of the velocity loop's time constant",
            typical=0.5,
            shared=True,
            relative=True,
            scan=(0.5, 3.0),
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = True
    changes = "tau_v"
    compensable = False
    confused_with = (
        ("servo_delay", "step the setpoint: a delay does nothing at first, a slow speed rises at once"),
        ("servo_bandwidth", "move at a constant speed: the velocity loop then leaves no error"),
        ("speed_integral", "ramp the setpoint: an integral part overshoots, and comes back as it forgets"),
    )

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return number * (1.0 + np.asarray(values.get("relative", 0.0), dtype=float))

    def adjust(self, core: Core, now: Now) -> None:
        core.tau_v = core.tau_v * (1.0 + self["relative"])
