"""What goes with the way that a joint goes to and fro, stated as what it makes in time at a mean speed."""

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.parameter import Parameter

SPEED = Parameter(
    "speed", "rad/s", (1e-6, 100.0), "mean speed of the joint in the recording it was fitted on",
    typical=0.1, null=0.1, measured=True,
)  # fmt: skip


class Travelled(Effect):
    """An effect with a form in which it goes with that way."""

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """The mean speed is what the motion has."""
        if parameter.name != SPEED.name:
            return super().grid(parameter, now, column, rest)
        mean = np.sum(np.abs(now.speed[:, column]) * now.dt) / max(np.sum(now.dt), 1e-9)
        return (float(np.clip(mean, *SPEED.bounds)),)
