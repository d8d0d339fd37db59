"""A link is longer or shorter."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class LinkLengthError(Effect):
    """l_i + length_error: along the line from the joint to the next one, with the arm at 0."""

    id = "link_length_error"
    stage, place, regime = "arm", 100, "always"
    shifts_links = in_plane = True
    signature = "The tip is off along one link's direction, in every posture."
    source = "Mooring, Roth & Driels, Fundamentals of Manipulator Calibration (1991), ch. 3."
    parameters = (Parameter("length_error", "m", (-0.05, 0.05), "length less nominal length", typical=5e-4),)
    confused_with = (("base_tilt", "turn the arm to both sides: a tilt turns with it, a length does not"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.geometry.shift += self["length_error"][:, None] * core.along
