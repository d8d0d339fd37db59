"""The joint readings are late."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import delayed
from trunk_ros.parameter import Parameter

LONGEST = 0.5  # s


class SensorDelay(Effect):
    """theta_shown(t) = theta(t - delay)."""

    id = "sensor_delay"
    stage, place, regime = "wire", 700, "high_speed"
    signature = "The residual follows speed on all joints alike: the whole curve is shifted in time."
    source = "Constant transport delay; whatever its cause, a lag of the readings."
    parameters = (Parameter("delay", "s", (0.0, LONGEST), "age of a reading at its stamp", typical=0.01, shared=True,
                            scan=(0.005, 0.02, 0.08)),)
    compensable = False
    everywhere = True
    confused_with = (("viscous_lag", "stop abruptly: a delay keeps the shape, a lag rounds it"),)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        delay = np.broadcast_to(self["delay"], x.shape[1:])
        stamps, past = (now.stamp[:0], x[:0]) if state is None else state
        stamps, past = np.concatenate([stamps, now.stamp]), np.concatenate([past, x])
        out = np.empty_like(x)
        delayed(stamps, past, delay, len(stamps) - len(x), out)
        kept = max(int(np.searchsorted(stamps, stamps[-1] - LONGEST)) - 2, 0)
        return out, (stamps[kept:], past[kept:])
