"""The base, or the frame that the tip is measured in, stands elsewhere."""

from typing import ClassVar

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.geometric import FrameError
from trunk_ros.parameter import Parameter

AXES = ("x", "y", "z")


class BaseShift(FrameError):
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
    rows: ClassVar = {axis: row for row, axis in enumerate(AXES)}
    confused_with = (("tool_offset", "turn the last link: the tool's offset turns with it"),)

    def frame(self, core: Core) -> Array:
        return core.geometry.base
