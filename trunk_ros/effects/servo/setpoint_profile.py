"""The drive leads its shaft to each setpoint along a profile: it gathers speed, and brakes, at some rate."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import View
from trunk_ros.effects.servo.acceleration_limit import accelerations_seen
from trunk_ros.parameter import Parameter

UNLIMITED = 1e6  # rad/s^2


class SetpointProfile(Effect):
    """The loop goes to led, which stops at the setpoint soonest: led'' = +-acceleration, |led'| <= v_max."""

    id = "setpoint_profile"
    stage, place, regime = "servo", 100, "high_speed"
    scalable = False
    signature = (
        "After steps the gearbox's speed rises and falls along straight lines, and it stops without "
        "overshoot; in smooth moves it lags by the square of its speed."
    )
    source = (
        "Drives in profile position mode: 0x6083 of CiA 402 (and 0x6084), Profile Acceleration of smart "
        "servos, step generators of stepper motors. An infinite one is no profile, and v_max that of it."
    )
    parameters = (
        Parameter(
            "acceleration",
            "rad/s^2",
            (1e-2, UNLIMITED),
            "by which the profile gathers speed and brakes",
            typical=1.0,
            null=UNLIMITED,
            scale="log",
            shared=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = True
    view = View("time", window=6.0)
    compensable = False
    confused_with = (
        ("acceleration_limit", "step the setpoint: without a profile the shaft overshoots it"),
        ("velocity_loop", "step the setpoint by much and by little: a loop takes as long for both"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        ramp = np.where(self["acceleration"] < UNLIMITED, self["acceleration"], np.inf)
        core.ramp = np.minimum(core.ramp, ramp)

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        return accelerations_seen(now, column)
