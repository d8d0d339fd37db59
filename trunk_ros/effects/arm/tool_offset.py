"""The tool, or the marker that is measured, sits elsewhere on the last link."""

from typing import ClassVar

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.geometric import FrameError
from trunk_ros.parameter import Parameter

AXES = (("x", "m"), ("y", "m"), ("z", "m"), ("roll", "rad"), ("pitch", "rad"), ("yaw", "rad"))
TYPICAL = {"m": 5e-4, "rad": 2e-3}


class ToolOffset(FrameError):
    """The tip is moved and turned along and about its own axes, in every posture by the same."""

    id = "tool_offset"
    stage, place, regime = "arm", 220, "always"
    signature = "The tip is off by a vector that turns with the last link."
    source = "Tsai & Lenz (1989), IEEE Trans. Robot. Autom. 5(3): hand-eye calibration."
    parameters = tuple(
        Parameter(
            name, unit, (-1.0, 1.0), "along or about the tip's own axis", typical=TYPICAL[unit], shared=True,
            optional=name != "x",
        )
        for name, unit in AXES
    )  # fmt: skip
    rows: ClassVar = {name: row for row, (name, _) in enumerate(AXES)}
    confused_with = (("joint_zero_error", "a zero of the last joint turns the tool about its axis as well"),)

    def frame(self, core: Core) -> Array:
        return core.geometry.tool
