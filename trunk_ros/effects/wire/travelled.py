"""What goes with the way that a joint goes to and fro, stated as what it makes in time at a mean speed."""

from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.filters import lowpass
from trunk_ros.guards import TINY
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

    def settles(self, now: Now) -> bool:
        """Whether what takes a time to come neither comes at once nor long after the recording."""
        share = self["time_constant"] / (now.stamp[-1] - now.stamp[0])
        return bool(np.all((share > 0.08) & (share < 3.0)))

    def heat(self, now: Now, state: Any) -> tuple[Array, Any]:
        """(n, columns): 1 in the end where a joint goes on at its ``speed``."""
        memory = np.zeros((2, len(self["speed"]))) if state is None else state.copy()
        way = np.diff(now.travelled(None), axis=0, prepend=0.0)
        power, heat = way / np.maximum(now.dt, TINY)[:, None] / self["speed"], np.empty_like(way)
        lowpass(power, now.dt, self["time_constant"], memory, heat)
        return heat, memory
