"""The servo's speed changes no faster than its drive or its motor lets it."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import View
from trunk_ros.parameter import Parameter

UNLIMITED = 1e6  # rad/s^2
SEEN = (0.999, 0.99, 0.95)  # quantiles of accelerations that were seen, while the limit was reached


class AccelerationLimit(Effect):
    """v' = clip((v_ref - v) / tau_v, -acceleration, acceleration)."""

    id = "acceleration_limit"
    stage, place, regime = "servo", 100, "high_speed"
    scalable = False
    signature = "After steps the gearbox's speed rises and falls along straight lines, and it overshoots."
    source = "The motor's largest current over its inertia, or a drive's ramp: 0x6083 of CiA 402."
    parameters = (
        Parameter(
            "acceleration",
            "rad/s^2",
            (1e-2, UNLIMITED),
            "largest change of the gearbox's speed",
            typical=1.0,
            null=UNLIMITED,
            scale="log",
            shared=True,
        ),
    )
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = True
    view = View("time", window=6.0)
    compensable = False
    confused_with = (
        ("velocity_loop", "step the setpoint by little: a slow velocity loop overshoots there as well"),
        ("velocity_saturation", "make a slow move with sharp turns: the top speed then changes nothing"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        hardest = np.where(self["acceleration"] < UNLIMITED, self["acceleration"], np.inf)
        core.hardest = np.minimum(core.hardest, hardest)

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        return accelerations_seen(now, column)


def accelerations_seen(now: Now, column: int) -> tuple[float, ...]:
    """Hard ones of a gearbox [rad/s^2], from which to look for the hardest that its drive allows."""
    moving = now.dt > 0.0
    speed = now.speed[moving, column] / now.ratio[column]
    changes = np.abs(np.diff(speed) / now.dt[moving][1:])
    return tuple(max(float(a), 2e-2) for a in np.quantile(changes, SEEN)) if len(changes) else (1.0,)
