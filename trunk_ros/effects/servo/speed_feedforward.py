"""The servo is fed how fast its setpoint moves, more or less than the model says."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class SpeedFeedforward(Effect):
    """v_ref = Kp e + (feedforward + share) v_setpoint; feedforward + share >= 0."""

    id = "speed_feedforward"
    sizes = ("share",)
    stage, place, regime = "servo", 100, "high_speed"
    signature = (
        "At a constant speed the gearbox is less far behind its setpoint, with overshoot at each stop."
    )
    source = "Velocity feedforward of position loops, a drive's own setting: 0 to 1, mostly left at 0."
    parameters = (
        Parameter(
            "share",
            "1",
            (-2.0, 2.0),
            "share of the setpoint's speed that the velocity loop gets, beside what the model says",
            typical=0.1,
            shared=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = True
    changes = "feedforward"
    compensable = False
    confused_with = (
        ("servo_bandwidth", "step the setpoint: a higher gain comes nearer sooner, without overshoot"),
        ("servo_delay", "step the setpoint: a delay does nothing at first"),
    )

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return np.maximum(number + np.asarray(values.get("share", 0.0), dtype=float), 0.0)

    def adjust(self, core: Core, now: Now) -> None:
        core.feedforward = np.maximum(core.feedforward + self["share"], 0.0)
