"""The tool, or the marker that is measured, sits elsewhere on the last link."""

import numpy as np

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter

AXES = (("x", "m"), ("y", "m"), ("z", "m"), ("roll", "rad"), ("pitch", "rad"), ("yaw", "rad"))
TYPICAL = {"m": 5e-4, "rad": 2e-3}


class ToolOffset(Effect):
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
    everywhere = True
    confused_with = (("joint_zero_error", "a zero of the last joint turns the tool about its axis as well"),)

    def adjust(self, core: Core, now: Now) -> None:
        for row, (name, _) in enumerate(AXES):
            core.geometry.tool[row] += float(np.ravel(self.values.get(name, 0.0))[0])
