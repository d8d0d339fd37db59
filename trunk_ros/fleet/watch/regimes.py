"""What a change looks like in the residual, by regime: one weight per sample, joint and regime.

A residual times such a weight, summed, is the size of the change that has this look.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array, compiled

REGIMES = ("always", "posture", "reversal", "low_speed", "high_speed", "hold", "scatter")
SCATTER = REGIMES.index("scatter")
SLOW = 0.05  # rad/s on the joint side, below which a motion is slow
STANDS = 0.004  # rad/s, below which a joint stands
MOST = 3.0  # usual sizes that an angle or a speed counts for
USUAL_ANGLE, USUAL_SPEED = 0.15, 0.1  # rad, rad/s: sizes that weights are of the order of one at


@dataclass
class Motion:
    """Memory of the motion: the last direction of each joint (joints,), 0 until it has moved."""

    direction: Array

    def weights(self, angle: Array, speed: Array) -> Array:
        """Weights (n, joints, regimes but the last) of ``angle`` and ``speed`` (n, joints) rad, rad/s."""
        along = np.empty_like(speed)
        directions(speed, self.direction, along)
        size, moves = np.abs(speed), np.abs(speed) > STANDS
        out = np.empty((*angle.shape, SCATTER))
        out[..., 0] = 1.0
        out[..., 1] = np.clip(angle / USUAL_ANGLE, -MOST, MOST)
        out[..., 2] = along
        out[..., 3] = along * (moves & (size < SLOW))
        out[..., 4] = np.clip(speed / USUAL_SPEED, -MOST, MOST) * (size > SLOW)
        out[..., 5] = ~moves
        return out


@compiled
def directions(speed: Array, last: Array, out: Array) -> None:
    """Sign of the last motion (n, joints); ``last`` (joints,) is carried on."""
    for j in range(speed.shape[1]):
        for k in range(speed.shape[0]):
            if abs(speed[k, j]) > STANDS:
                last[j] = 1.0 if speed[k, j] > 0.0 else -1.0
            out[k, j] = last[j]
