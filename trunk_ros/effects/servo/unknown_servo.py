"""Physics of the servo that no name fits."""

from trunk_ros.effects.curve import Curve


class UnknownServo(Curve):
    """phi += curve(x), x being position (ratio phi), speed, time, load or another joint's angle, held
    beyond its ends.
    """

    id = "unknown_servo"
    stage = "servo"
    place = 250
    compensable = False
    confused_with = (("cogging", "move over a wider range: a cogging goes on with its period"),)
