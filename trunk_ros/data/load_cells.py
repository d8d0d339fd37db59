"""What the joints' own effort is used for, and whether it is a load at all."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.noise import rms
from trunk_ros.derivatives import smooth
from trunk_ros.effort import MOVES
from trunk_ros.levels import MOST, PART, SURE
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.signal.fill import fill
from trunk_ros.resistance import load_cells, tells

BEFORE, LATEST = 0.1, 0.4  # s from a reversal: what turns over has, and the posture is as it was
REVERSALS = 6  # fewer cannot tell


def celled(recordings: Sequence[Recording]) -> set[str]:
    """Joints whose own effort is told in one of the recordings."""
    shown = [r.series["joint_states"] for r in recordings if "joint_states" in r.series]
    return {
        j for s in shown for j, told in zip(s.joints, tells(load_cells(s.joints, s)), strict=True) if told
    }


def cell_remarks(recording: Recording, model: ArmModel) -> list[str]:
    """On which joints ``effort`` of joint_states is the load, and on which it is no load by its sign."""
    shown = recording.series.get("joint_states")
    if model.arm.load_from != "effort" or shown is None or shown.effort is None:
        return []
    joints = shown.joints if model.any_joints else tuple(j for j in model.arm.joints if j in shown.joints)
    cells = load_cells(joints, shown)
    told = tells(cells)
    if not told.any():
        return []
    names, theta, effort = np.array(joints), fill(shown.select(joints).position), fill(cells)
    weight = model.for_joints(joints).loaded_arm().uncoupled().only(joints).load(theta)
    said = [f"load on {', '.join(names[told])} from effort of joint_states"]
    drives = [
        names[j]
        for j in np.flatnonzero(told)
        if _against(effort[:, j], weight[:, j]) or _drives(shown.stamp, theta[:, j], effort[:, j])
    ]
    if drives:
        said.append(
            f"effort of joint_states is a motor's torque on {', '.join(drives)}: it acts against the weight, "
            "or with the motion. A load is positive where it tends to increase the angle; the torque of "
            "motors, as ros2_control publishes it, belongs on trunk/gearbox_states"
        )
    return said


def _against(effort: Array, weight: Array) -> bool:
    """Whether an effort (n,) N m is opposed to the computed weight (n,) N m."""
    both = float(np.linalg.norm(effort) * np.linalg.norm(weight))
    return both > 0.0 and float(effort @ weight) < -MOST * both


def _drives(stamp: Array, angle: Array, effort: Array) -> bool:
    """Whether an effort (n,) N m turns over with the motion, as that which overcomes friction does."""
    speed = smooth(stamp, angle[:, None])[1][:, 0]
    moves = np.flatnonzero(np.abs(speed) > MOVES)
    jumps = []
    for last, first in pairwise(moves):
        if speed[last] * speed[first] < 0.0:
            begin, end = stamp[last], stamp[first]
            before = effort[(stamp > begin - LATEST) & (stamp < begin - BEFORE)]
            after = effort[(stamp > end + BEFORE) & (stamp < end + LATEST)]
            if len(before) and len(after):
                jumps.append(np.sign(speed[first]) * (after.mean() - before.mean()) / 2.0)
    if len(jumps) < REVERSALS:
        return False
    usual, spread = float(np.mean(jumps)), float(np.std(jumps)) / np.sqrt(len(jumps))
    return usual > SURE * spread and usual > PART * rms(effort)
