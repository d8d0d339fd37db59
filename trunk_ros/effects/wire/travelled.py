"""What goes with the way that a joint goes to and fro, stated as what it makes in time at a mean speed."""

import numpy as np

from trunk_ros.effects.now import Now
from trunk_ros.parameter import Parameter

SPEED = Parameter(
    "speed", "rad/s", (1e-6, 100.0), "mean speed of the joint in the recording it was fitted on",
    typical=0.1, null=0.1, measured=True,
)  # fmt: skip


def mean_speed(now: Now, column: int) -> float:
    """Mean size of a column's speed [rad/s]."""
    mean = np.sum(np.abs(now.speed[:, column]) * now.dt) / max(np.sum(now.dt), 1e-9)
    return float(np.clip(mean, *SPEED.bounds))
