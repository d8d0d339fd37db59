"""A joint sits beside the place that the description has for it."""

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Now
from trunk_ros.effects.geometric import Sideways, sideways


class LinkOffsetError(Sideways):
    """What follows a joint is shifted across the line to the next joint, in two directions."""

    id = "link_offset_error"
    stage, place, regime = "arm", 110, "always"
    shifts_links = True
    signature = "The tip is off across one link's direction, in every posture."
    source = "Hayati (1983), IEEE CDC: link parameter errors beside Denavit-Hartenberg's lengths."
    parameters = sideways("across", "m", 0.1, "shift across the link, direction {}", 5e-4)
    confused_with = (("link_length_error", "turn the joints on either side of the link"),)

    def adjust(self, core: Core, now: Now) -> None:
        core.geometry.shift += self.sideways(core.across)
