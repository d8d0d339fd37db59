"""Joint encoders so coarse that their steps are seen, on joints that rest more than they move."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.recording.recording import JointSeries
from trunk_ros.recording.signal.encoder import count
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.resample import resample

WITHIN = 0.2  # s


def coarse_steps(gearbox: JointSeries, shown: JointSeries, arm: Arm) -> dict[str, float]:
    """Step [rad] of the encoder of each joint that mostly rests and whose dead band is hidden in its steps;
    the series have the same joints.
    """
    phi, _ = resample(gearbox, np.clip(shown.stamp, gearbox.stamp[0], gearbox.stamp[-1]))
    u, readings = phi * arm.ratio, fill(shown.position)
    if len(shown.stamp) < 2:
        return {}
    apart = max(round(WITHIN / float(np.median(np.diff(shown.stamp)))), 1)
    out = {}
    for j, joint in enumerate(shown.joints):
        step = count(readings[:, j])
        moved = np.abs(u[apart:, j] - u[:-apart, j])
        whole = 2.0 * arm.dead_band[j]  # from one side to the other: a larger step hides it
        if step > whole > 0.0 and float(np.median(moved)) < step:
            out[joint] = step
    return out
