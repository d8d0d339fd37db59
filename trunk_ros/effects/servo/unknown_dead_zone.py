"""Errors that a servo does not answer to."""

from dataclasses import replace

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.curve import RANGE, VALUES, Curve
from trunk_ros.effects.effect import Now

TYPICAL = 5e-3  # rad


class UnknownDeadZone(Curve):
    """The loop takes errors within +- curve(x) for none, x being position (ratio phi), speed, time or load;
    the zone is never less than nothing.
    """

    id = "unknown_dead_zone"
    stage = "servo"
    place = 100
    signature = "The gearbox stops short of its setpoint, on the side that it comes from."
    regime = "reversal"
    compensable = False
    hides = True
    parameters = (*RANGE, *(replace(p, typical=TYPICAL) for p in VALUES))
    of = "the error that the servo does not answer to"
    confused_with = (("cogging", "approach one setpoint from both sides: a dead zone changes its sign"),)

    @classmethod
    def over(cls, variables: list[str], own: list[str]) -> list[str]:
        return [variable for variable in own if variable == "position"]

    def adjust(self, core: Core, now: Now) -> None:
        core.dead_zone = np.maximum(core.dead_zone + self._curve(now), 0.0)
