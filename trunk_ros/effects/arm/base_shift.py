"""The base, or the frame that the tip is measured in, stands elsewhere."""

import numpy as np

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter

AXES = ("x", "y", "z")


class BaseShift(Effect):
    """The tip is moved along the base's axes, in every posture by the same."""

    id = "base_shift"
    stage, place, regime = "arm", 210, "always"
    signature = "The tip is off by the same vector in every posture."
    source = "Tsai & Lenz (1989), IEEE Trans. Robot. Autom. 5(3): a camera's frame against the robot's."
    parameters = tuple(
        Parameter(
            axis, "m", (-1.0, 1.0), f"shift along {axis.upper()}", typical=5e-4, shared=True, optional=k > 0
        )
        for k, axis in enumerate(AXES)
    )
    everywhere = True
    confused_with = (("tool_offset", "turn the last link: the tool's offset turns with it"),)

    def adjust(self, core: Core, now: Now) -> None:
        for row, axis in enumerate(AXES):
            core.geometry.base[row] += float(np.ravel(self.values.get(axis, 0.0))[0])
