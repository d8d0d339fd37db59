"""The joint readings are late."""

from typing import Any

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import shifted
from trunk_ros.parameter import Parameter

LONGEST = 0.5  # s


class SensorDelay(Effect):
    """theta_shown(t) = theta(t - delay)."""

    id = "sensor_delay"
    stage, place, regime = "wire", 700, "high_speed"
    exact = True
    signature = "The residual follows speed on all joints alike: the whole curve is shifted in time."
    source = "Constant transport delay; whatever its cause, a lag of the readings."
    parameters = (
        Parameter(
            "delay",
            "s",
            (0.0, LONGEST),
            "age of a reading at its stamp",
            typical=0.01,
            shared=True,
            scan=(0.005, 0.02, 0.08),
        ),
    )
    compensable = False
    delays_readings = True
    everywhere = begins = True
    imitated_by = ("skew", "clock_step", "repeats")
    confused_with = (("viscous_lag", "stop abruptly: a delay keeps the shape, a lag rounds it"),)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return shifted(x, now.dt, self["delay"], LONGEST, state)
