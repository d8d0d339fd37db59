"""The servo's speed changes no faster than its drive or its motor lets it."""

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.servo.accelerating import Accelerating, acceleration


class AccelerationLimit(Accelerating):
    """v' = clip((v_ref - v) / tau_v, -acceleration, acceleration)."""

    id = "acceleration_limit"
    signature = "After steps the gearbox's speed rises and falls along straight lines, and it overshoots."
    source = "The motor's largest current over its inertia, or a drive's ramp: 0x6083 of CiA 402."
    parameters = acceleration("largest change of the gearbox's speed")
    confused_with = (
        ("velocity_loop", "step the setpoint by little: a slow velocity loop overshoots there as well"),
        ("velocity_saturation", "make a slow move with sharp turns: the top speed then changes nothing"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.hardest = np.minimum(core.hardest, self.rate)
