"""The poses of the tip are late."""

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class TipDelay(Effect):
    """The tip is where the joints were ``delay`` s ago."""

    id = "tip_delay"
    stage, place, regime = "arm", 150, "high_speed"
    signature = "The tip trails behind the joints in proportion to their speed."
    source = "Furgale, Rehder & Siegwart (2013), IROS: time offset between a camera and other sensors."
    parameters = (Parameter("delay", "s", (-0.5, 0.5), "age of the poses", typical=5e-3, shared=True),)
    everywhere = True
    confused_with = (("joint_zero_error", "stand still: a delay is gone at rest"),)
    compensable = False

    def adjust(self, core: Core, now: Now) -> None:
        core.bent = core.bent - float(np.ravel(self["delay"])[0]) * now.speeds
