"""Physics of the wire that no name fits."""

from trunk_ros.effects.curve import Curve


class Unknown(Curve):
    """theta += curve(x), x being position (ratio phi), speed, time, load, another joint's angle or its
    speed; straight beyond its ends, over time held.
    """

    id = "unknown"
    follows_readings = True
    linear = True
    stage = "wire"
    place = 250
    imitated_by = (
        "burst",
        "clock_step",
        "early",
        "filtered",
        "hum",
        "knocks",
        "repeats",
        "thinned",
        "wandering_latency",
        "wrap",
    )
    confused_with = (
        ("transmission_ripple", "move over a wider range: a ripple goes on with its period"),
        ("wire_stiffening", "carry a payload: what depends on the load goes on where the bare arm ended"),
    )

    @classmethod
    def over(cls, variables: list[str], own: list[str]) -> list[str]:
        return variables
