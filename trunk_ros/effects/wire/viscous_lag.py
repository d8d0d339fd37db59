"""The joint lags in proportion to speed."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import lowpass, rate, shifted
from trunk_ros.parameter import Parameter

LONGEST = 2.0  # s


class ViscousLag(Effect):
    """time_constant dtheta/dt + theta = p, or theta(t) = p(t - time_constant), or theta = p - time_constant
    dp/dt.
    """

    id = "viscous_lag"
    stage, place, regime = "wire", 400, "high_speed"
    begins = True
    signature = "The residual follows the joint's speed, and is gone when it stands."
    source = "Kelvin-Voigt: damping c against the wire's stiffness k gives a first-order lag c/k."
    forms = ("first_order", "shift", "proportional")
    parameters = (
        Parameter("time_constant", "s", (0.0, LONGEST), "lag behind a steady motion", typical=0.01),
    )
    imitated_by = ("clock_step",)
    confused_with = (("sensor_delay", "stop abruptly: a delay keeps the shape, a lag rounds it"),)

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        if self.form == "shift":
            return shifted(x, now.dt, self["time_constant"], LONGEST, state)
        if self.form == "proportional":
            speed, state = rate(x, now.dt, state)
            return x - self["time_constant"] * speed, state
        state = np.vstack([x[0], x[0]]) if state is None else state.copy()
        out = np.empty_like(x)
        lowpass(x, now.dt, self["time_constant"], state, out)
        return out, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        first, second = (None, None) if state is None else state
        speed, first = rate(y, now.dt, first)
        out = y + self["time_constant"] * speed
        if self.form != "first_order":
            acceleration, second = rate(speed, now.dt, second)
            out += self["time_constant"] ** 2 * acceleration * (0.5 if self.form == "shift" else 1.0)
        return out, (first, second)
