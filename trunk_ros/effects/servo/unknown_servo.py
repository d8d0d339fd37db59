"""Physics of the servo that no name fits."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.curve import Curve
from trunk_ros.effects.effect import Now


class UnknownServo(Curve):
    """setpoint += curve(x), x being position (ratio phi), speed, time, load, another joint's angle or its
    speed.
    """

    id = "unknown_servo"
    stage = "servo"
    place = 100
    compensable = False
    of = "what the servo makes of its setpoint"
    confused_with = (("cogging", "move over a wider range: a cogging goes on with its period"),)

    @classmethod
    def over(cls, variables: list[str], own: list[str]) -> list[str]:
        return variables

    def adjust(self, core: Core, now: Now) -> None:
        core.pull = core.pull + self._curve(now)
