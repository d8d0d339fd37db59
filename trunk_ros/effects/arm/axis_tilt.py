"""A joint's axis is tilted."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.geometric import Sideways, sideways


class AxisTilt(Sideways):
    """The axis of a joint is turned about two directions across it; the arm with all joints at 0 stays."""

    id = "axis_tilt"
    stage, place, regime = "arm", 120, "always"
    signature = "The farther a joint is from 0, the farther the tip is off its circle."
    source = "Hayati (1983), IEEE CDC: neighbouring axes that are nearly parallel."
    parameters = sideways("tilt", "rad", 0.5, "turn about the direction {} across the axis", 2e-3)
    confused_with = (("link_offset_error", "measure the orientation of the tip as well"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.geometry.tilt += self.sideways(core.beside)
