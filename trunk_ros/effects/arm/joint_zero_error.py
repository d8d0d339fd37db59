"""A joint stands elsewhere than its sensor says, by a constant."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class JointZeroError(Effect):
    """theta + offset moves the tip, where theta is read."""

    id = "joint_zero_error"
    stage, place, regime = "arm", 130, "always"
    signature = "The tip is turned about one joint's axis by a constant angle."
    source = "Mooring, Roth & Driels, Fundamentals of Manipulator Calibration (1991), ch. 3: joint offsets."
    parameters = (Parameter("offset", "rad", (-1.0, 1.0), "angle less its reading", typical=2e-3),)
    moves_joints = True
    confused_with = (("base_tilt", "turn the other joints: a tilt is about the base, not about the joint"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.geometry.zero += self["offset"]
