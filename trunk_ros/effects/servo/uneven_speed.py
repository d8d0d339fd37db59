"""The servo is faster one way than the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.effects.core import Core, up_and_down
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import View
from trunk_ros.parameter import Parameter


class UnevenSpeed(Effect):
    """v_ref = clip(Kp e, -(1 - excess) v_max, (1 + excess) v_max)."""

    id = "uneven_speed"
    sizes = ("excess",)
    stage, place, regime = "servo", 100, "high_speed"
    signature = "Fast moves to and fro drift one way: the top speed is higher that way, and lower back."
    source = "Cylinders with one rod: the areas of both sides; brushed motors: advanced timing; springs."
    parameters = (
        Parameter("excess", "1", (-0.9, 0.9), "share by which it is faster up, slower down", typical=0.05),
    )
    changes = "top_speeds"
    view = View("time", window=6.0)
    compensable = False
    confused_with = (
        ("load_droop", "move fast and slowly: a droop is there at rest, and at any speed"),
        ("servo_offset", "move slowly: an offset stays"),
    )

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return np.array(up_and_down(number[0], np.asarray(values.get("excess", 0.0), dtype=float)))

    def adjust(self, core: Core, now: Now) -> None:
        core.uneven = core.uneven + self["excess"]
