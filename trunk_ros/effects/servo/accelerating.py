"""Drives in which some speed changes no faster than at a rate."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.now import View
from trunk_ros.parameter import Parameter

UNLIMITED = 1e6  # rad/s^2
SEEN = (0.999, 0.99, 0.95)  # quantiles of accelerations that were seen, while the limit was reached


def acceleration(description: str) -> tuple[Parameter]:
    """The rate, which all joints share."""
    rate = Parameter(
        "acceleration",
        "rad/s^2",
        (1e-2, UNLIMITED),
        description,
        typical=1.0,
        null=UNLIMITED,
        scale="log",
        shared=True,
    )
    return (rate,)


class Accelerating(Effect):
    """What acts on one of these speeds."""

    stage, place, regime = "servo", 100, "high_speed"
    scalable = False
    forms = ("alike", "apart")
    apart = "apart"
    everywhere = True
    view = View("time", window=6.0)
    compensable = False

    @property
    def rate(self) -> Array:
        """(columns,) rad/s^2; inf where there is no limit."""
        return np.where(self["acceleration"] < UNLIMITED, self["acceleration"], np.inf)

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """Hard ones of the gearbox."""
        moving = now.dt > 0.0
        speed = now.speed[moving, column] / now.ratio[column]
        changes = np.abs(np.diff(speed) / now.dt[moving][1:])
        return tuple(max(float(a), 2e-2) for a in np.quantile(changes, SEEN)) if len(changes) else (1.0,)
