"""A joint's axis is tilted."""

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter

SIDES = ("tilt_1", "tilt_2")


class AxisTilt(Effect):
    """The axis of a joint is turned about two directions across it; the arm with all joints at 0 stays."""

    id = "axis_tilt"
    stage, place, regime = "arm", 120, "always"
    signature = "The farther a joint is from 0, the farther the tip is off its circle."
    source = "Hayati (1983), IEEE CDC: neighbouring axes that are nearly parallel."
    parameters = tuple(
        Parameter(side, "rad", (-0.5, 0.5), f"turn about the direction {k} across the axis", typical=2e-3)
        for k, side in enumerate(SIDES, start=1)
    )
    confused_with = (("link_offset_error", "measure the orientation of the tip as well"),)

    def adjust(self, core: Core, now: Now) -> None:
        for k, side in enumerate(SIDES):
            core.geometry.tilt += self[side][:, None] * core.beside[:, k]
