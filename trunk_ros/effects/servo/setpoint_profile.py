"""The drive leads its shaft to each setpoint along a profile: it gathers speed, and brakes, at some rate."""

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.servo.accelerating import Accelerating, acceleration


class SetpointProfile(Accelerating):
    """The loop goes to led, which stops at the setpoint soonest: led'' = +-acceleration, |led'| <= v_max."""

    id = "setpoint_profile"
    signature = (
        "After steps the gearbox's speed rises and falls along straight lines, and it stops without "
        "overshoot; in smooth moves it lags by the square of its speed."
    )
    source = (
        "Drives in profile position mode: 0x6083 of CiA 402 (and 0x6084), Profile Acceleration of smart "
        "servos, step generators of stepper motors. An infinite one is no profile, and v_max that of it."
    )
    parameters = acceleration("by which the profile gathers speed and brakes")
    confused_with = (
        ("acceleration_limit", "step the setpoint: without a profile the shaft overshoots it"),
        ("velocity_loop", "step the setpoint by much and by little: a loop takes as long for both"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        core.ramp = np.minimum(core.ramp, self.rate)
