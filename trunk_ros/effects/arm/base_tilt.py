"""The base stands tilted about X."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class BaseTilt(Effect):
    """The tip [y, z, roll] turns about the base's X axis by ``angle``."""

    id = "base_tilt"
    stage, place, regime = "arm", 200, "always"
    signature = "The whole arm's picture is turned about the base, the roll is off by a constant."
    source = (
        "Mooring, Roth & Driels, Fundamentals of Manipulator Calibration (1991), ch. 3: base frame error."
    )
    parameters = (Parameter("angle", "rad", (-1.0, 1.0), "turn about +X", typical=2e-3, shared=True),)
    everywhere = True

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        angle = float(np.ravel(self["angle"])[0])
        c, s = np.cos(angle), np.sin(angle)
        return np.column_stack([c * x[:, 0] - s * x[:, 1], s * x[:, 0] + c * x[:, 1], x[:, 2] + angle]), None
