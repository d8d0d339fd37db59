"""Setpoints take effect late, or less late than the model says: by less than nothing where their stamps are
late themselves.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter


class ServoDelay(Effect):
    """The loop sees the setpoint of ``delay`` ago, beside the model's own; in a recording also one that is
    stamped later.
    """

    id = "servo_delay"
    sizes = ("delay",)
    stage, place, regime = "servo", 100, "high_speed"
    signature = "The gearbox follows the setpoint's whole curve later than the loop would."
    source = "Transport delay of the field bus; stamps that are set when a message is recorded."
    parameters = (
        Parameter(
            "delay",
            "s",
            (-0.5, 0.5),
            "age of a setpoint when it acts, beside what the model says",
            typical=0.01,
            shared=True,
            scan=(-0.01, 0.005, 0.02, 0.08),
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = begins = True
    changes = "delay"
    compensable = False
    imitated_by = ("thinned", "wandering_latency", "repeats")
    confused_with = (
        ("servo_bandwidth", "step the setpoint: a delay does nothing at first, a slow loop starts at once"),
    )

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return number + np.asarray(values.get("delay", 0.0), dtype=float)

    def adjust(self, core: Core, now: Now) -> None:
        core.delay = core.delay + self["delay"]
