"""Motors that a recording shows faster than a model has them."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.data.motion_content import top_speed
from trunk_ros.levels import NEARLY
from trunk_ros.recording.recording import Recording


def too_slow(recording: Recording, model: ArmModel) -> list[str]:
    """In one line the joints whose motors go clearly faster than the model's servo may: a top speed that was
    not reached is a guess in a model that was found.
    """
    if not {"setpoints", "gearbox_states"} <= recording.series.keys() or not model.says_its_servos:
        return []
    model, seen = model.at_end(), recording.series["gearbox_states"]
    tops = np.maximum(*model.top_speeds)
    went = {
        j: top_speed(seen.stamp, seen.select((j,)).position) for j in model.arm.joints if j in seen.joints
    }
    faster = {
        j: top for j, top in zip(model.arm.joints, tops, strict=True) if NEARLY * went.get(j, 0.0) > top
    }
    return [
        "motors go faster than the servo of the model may: "
        + ", ".join(f"{j} {went[j]:.3g} rad/s, v_max {top:.3g}" for j, top in faster.items())
        + "; no motion may have shown its top speed where it was found: set servo.v_max, or diagnose this one"
    ] * bool(faster)
