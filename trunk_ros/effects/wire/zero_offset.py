"""The zeros of gearbox and joint differ."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import ANY, Parameter


class ZeroOffset(Effect):
    """theta_shown = theta + offset."""

    id = "zero_offset"
    stage, place, regime = "wire", 800, "always"
    exact = True
    of_every_joint = shifts_readings = True
    signature = "The residual has a mean that nothing changes."
    source = "Calibration of the zeros."
    parameters = (
        Parameter("offset", "rad", ANY, "joint reading where the gearbox shows zero", typical=1e-3),
    )
    imitated_by = ("whole_turns", "steps")
    confused_with = (
        ("thermal_drift", "look at the start: a drift begins at zero"),
        ("backlash", "turn the joint: a dead band changes its sign"),
        ("joint_coupling", "move the joints that stood: a coupling follows them"),
    )

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self["offset"], None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self["offset"], None

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """As much as is to be explained: a joint that stands as it began shows only what is beyond its play,
        so that a look at any other size is no look at this one.
        """
        size = 0.0 if rest is None else float(np.sqrt(np.mean(rest**2)))
        return (size,) if size > 0.0 else super().grid(parameter, now, column, rest)
