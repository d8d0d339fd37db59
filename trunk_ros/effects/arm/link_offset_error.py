"""A joint sits beside the place that the description has for it."""

from trunk_ros.effects.effect import Core, Effect, Now
from trunk_ros.parameter import Parameter

SIDES = ("across_1", "across_2")


class LinkOffsetError(Effect):
    """What follows a joint is shifted across the line to the next joint, in two directions."""

    id = "link_offset_error"
    stage, place, regime = "arm", 110, "always"
    shifts_links = True
    signature = "The tip is off across one link's direction, in every posture."
    source = "Hayati (1983), IEEE CDC: link parameter errors beside Denavit-Hartenberg's lengths."
    parameters = tuple(
        Parameter(side, "m", (-0.1, 0.1), f"shift across the link, direction {k}", typical=5e-4)
        for k, side in enumerate(SIDES, start=1)
    )
    confused_with = (("link_length_error", "turn the joints on either side of the link"),)

    def adjust(self, core: Core, now: Now) -> None:
        for k, side in enumerate(SIDES):
            core.geometry.shift += self[side][:, None] * core.across[:, k]
