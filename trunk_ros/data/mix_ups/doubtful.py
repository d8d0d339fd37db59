"""Angles that may be degrees, where nothing says that they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.arm.parameters import ANY_ANGLE
from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.pair import MixUp
from trunk_ros.data.motion_content import APART
from trunk_ros.data.sensing.wraps import TURN, unwrapped
from trunk_ros.levels import FEWEST, OUTLIERS
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.topics import COMPARED, TOPICS

WIDEST = 2.0 * TURN  # rad that few joints go
FASTEST = 20.0  # rad/s that few joints do


def doubtful(recording: Recording, model: ArmModel, mixed: Sequence[MixUp] = ()) -> list[str]:
    """In one line the joints that turn further or faster than joints do, whose angles may be degrees or
    counts; ``mixed``: what is said of them already. Limits of the model that allow for it settle it.
    """
    told = {joint for one in mixed for joint in one.joints}
    seen = [(TOPICS[key], _beyond(recording, model, recording.series[key], key, told))
            for key in COMPARED["wire"] if key in recording.series]  # fmt: skip
    if not any(beyond for _, beyond in seen):
        return []
    where = " and ".join(f"{topic} of {', '.join(beyond)}" for topic, beyond in seen if beyond)
    most, fast = np.max([each for _, beyond in seen for each in beyond.values()], axis=0)
    return [
        f"{where}: {most:.3g} rad from end to end at up to {fast:.2g} rad/s: are these rad? If they are "
        "degrees or counts, convert them (unit: deg in a mapping)"
    ]


def _beyond(
    recording: Recording, model: ArmModel, series: JointSeries, key: str, told: set[str]
) -> dict[str, tuple[float, float]]:
    """Width [rad] and speed [rad/s] of joints of which one is beyond what joints do, by joint; motors as the
    model turns joints by them.
    """
    arm, out = model.arm, {}
    if key == "gearbox_states" and arm.coupling is not None:
        return {}
    for joint, column in zip(series.joints, series.position.T, strict=True):
        if joint in told or recording.unit(joint) != "rad" or np.isfinite(column).sum() < FEWEST:
            continue
        known = joint in arm.joints
        ratio = abs(float(arm.ratio[arm.index(joint)])) if known and key == "gearbox_states" else 1.0
        width, speed = _motion(series.stamp, column)
        allowed = float(arm.upper[arm.index(joint)] - arm.lower[arm.index(joint)]) if known else 0.0
        wide = ratio * width > max(WIDEST, allowed if allowed < ANY_ANGLE else 0.0)
        if wide or ratio * speed > FASTEST:
            out[joint] = width, speed
    return out


def _motion(stamp: Array, angle: Array) -> tuple[float, float]:
    """Width [rad] and speed [rad/s] of most of what a joint (n,) does: stray readings do not count."""
    known = np.isfinite(angle)
    stamp, angle = stamp[known], unwrapped(angle[known])[0]
    low, high = np.quantile(angle, [OUTLIERS, 1.0 - OUTLIERS])
    steps, times = (np.abs(each[APART:] - each[:-APART]) for each in (angle, stamp))
    speeds = steps[times > 0.0] / times[times > 0.0]
    return float(high - low), float(np.quantile(speeds, 1.0 - OUTLIERS)) if len(speeds) else 0.0
