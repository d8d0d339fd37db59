"""A gain of the wire that depends on something in a way that no name fits."""

from dataclasses import replace

from trunk_ros.compiled import Array
from trunk_ros.effects.curve import RANGE, VALUES, Curve
from trunk_ros.effects.effect import Now


class UnknownGain(Curve):
    """theta += ratio phi curve(x), x being speed, time, load or another joint's angle; straight beyond
    its ends, over time held.
    """

    id = "unknown_gain"
    stage = "wire"
    place = 260
    signature = "The share of the motion that arrives depends on something in a way that no named effect has."
    parameters = (*RANGE, *(replace(p, unit="1") for p in VALUES))
    linear = True
    of, also = "the share of the motion that arrives", ("position",)
    confused_with = (("unknown", "be at one posture at different times, speeds and loads"),)

    @classmethod
    def over(cls, variables: list[str], own: list[str]) -> list[str]:
        return [variable for variable in own if variable not in cls.also]

    @classmethod
    def factor(cls, now: Now) -> Array:
        return now.gearbox * now.ratio
