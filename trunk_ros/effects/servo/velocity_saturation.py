"""The servo reaches a lower top speed than the model says, or a higher one."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import View
from trunk_ros.parameter import Parameter

UNLIMITED = 1e3  # rad/s
STEADY = 0.99  # of the top speed: the speeds of a servo that can go no faster, and their noise


class VelocitySaturation(Effect):
    """v_ref = clip(Kp e, -v_max, v_max) with another v_max."""

    id = "velocity_saturation"
    stage, place, regime = "servo", 100, "high_speed"
    scalable = False
    signature = (
        "In fast moves the gearbox falls behind at a constant speed, and follows exactly in slow ones."
    )
    source = "Supply voltage over the motor's back-EMF constant bounds its speed."
    parameters = (
        Parameter(
            "v_max",
            "rad/s",
            (1e-3, UNLIMITED),
            "top speed of the gearbox shaft",
            typical=0.8,
            null=UNLIMITED,
            scale="log",
            shared=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = begins = True
    changes = "v_max"
    view = View("time", window=6.0)
    compensable = False
    confused_with = (
        (
            "servo_bandwidth",
            "make the same move at a third of the speed: a slow loop lags there as well",
        ),
    )

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        return _instead(number, np.asarray(values.get("v_max", UNLIMITED), dtype=float))

    def adjust(self, core: Core, now: Now) -> None:
        core.v_max = _instead(core.v_max, self["v_max"])

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        return speeds_seen(now, column)


def speeds_seen(now: Now, column: int) -> tuple[float, ...]:
    """Speeds [rad/s] of a shaft that may be as fast as it is let: the one that it keeps, and near its top."""
    speed = np.abs(now.speed[:, column] / now.ratio[column])
    fast = float(speed.max())
    steady = float(np.median(speed[speed >= STEADY * fast]))
    return tuple(max(seen, 2e-3) for seen in (steady, *(share * fast for share in (0.995, 0.97, 0.85, 0.7))))


def _instead(v_max: Any, other: Array) -> Any:
    """``other`` where there is one; a number where both are."""
    return np.where(other < UNLIMITED, other, v_max)[()]
