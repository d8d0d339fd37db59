"""The joint lags in proportion to speed."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import lowpass, rate
from trunk_ros.parameter import Parameter


class ViscousLag(Effect):
    """time_constant dtheta/dt + theta = p."""

    id = "viscous_lag"
    stage, place, regime = "wire", 400, "high_speed"
    signature = "The residual follows the joint's speed, and is gone when it stands."
    source = "Kelvin-Voigt: damping c against the wire's stiffness k gives a first-order lag c/k."
    parameters = (Parameter("time_constant", "s", (0.0, 2.0), "lag behind a steady motion", typical=0.01),)
    confused_with = (("sensor_delay", "stop abruptly: a delay keeps the shape, a lag rounds it"),)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        state = np.vstack([x[0], x[0]]) if state is None else state.copy()
        out = np.empty_like(x)
        lowpass(x, now.dt, self["time_constant"], state, out)
        return out, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        speed, state = rate(y, now.dt, state)
        return y + self["time_constant"] * speed, state
