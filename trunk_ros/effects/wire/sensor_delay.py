"""The joint readings are late."""

from typing import Any

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import averaged, shifted
from trunk_ros.parameter import Parameter

LONGEST = 0.5  # s


class SensorDelay(Effect):
    """theta_shown(t) = theta(t - delay), or (averaged) the mean of theta over 2 share delay about that time,
    as far as it has come.
    """

    id = "sensor_delay"
    stage, place, regime = "wire", 700, "high_speed"
    exact = True
    signature = "The residual follows speed on all joints alike: the whole curve is shifted in time."
    source = "Constant transport delay; whatever its cause, a lag of the readings. averaged: moving average."
    forms = ("constant", "averaged")
    refined = ("averaged",)
    parameters = (
        Parameter(
            "delay",
            "s",
            (0.0, LONGEST),
            "age of a reading at its stamp, in the mean",
            typical=0.01,
            shared=True,
            scan=(0.005, 0.02, 0.08),
        ),
        Parameter(
            "share",
            "1",
            (0.0, 2.0),
            "of twice the delay: the time that is averaged",
            typical=1.0,
            shared=True,
        ),
    )
    compensable = False
    delays_readings = True
    everywhere = begins = True
    imitated_by = ("skew", "clock_step", "repeats")
    confused_with = (("viscous_lag", "stop abruptly: a delay keeps the shape, a lag rounds it"),)

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "averaged" else cls.parameters[:1]

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        if self.form == "averaged":
            window = 2.0 * self["share"] * self["delay"]
            return averaged(x, now.dt, self["delay"], window, 3.0 * LONGEST, state)
        return shifted(x, now.dt, self["delay"], LONGEST, state)
