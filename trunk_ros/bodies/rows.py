"""The rows of the regression: filtered alike, decimated, in blocks of time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from trunk_ros.arm import Arm
from trunk_ros.bodies.signals import BLOCK, KEPT, LEAST, PERIODS, TORQUE, Motion, lowpass
from trunk_ros.compiled import Array
from trunk_ros.errors import RecordingError

MEMORY = 0.5  # periods of the cut-off that the filter mixes in from either side
ENDS = 4  # times that at both ends of a recording, beyond which the filter has to guess


@dataclass(frozen=True)
class Rows:
    """Torque, and what each unknown would make of it; one row a joint and sample."""

    torque: Array
    """(n, joints) N m: recorded."""
    asked: Array
    """(n, joints) N m: what the model's links and payload ask for in this motion."""
    joint: Array
    """(n, joints, 3): of a joint's own friction, damping and armature."""
    link: Array
    """(n, joints, 10): of the last link's parameters, as Pinocchio orders them."""
    known: np.ndarray
    """(n, joints): which rows count."""
    block: np.ndarray
    """(n,): number of the block of time that a row is in."""

    @property
    def joints(self) -> int:
        """How many there are."""
        return int(self.torque.shape[1])


def rows_of(motions: list[Motion], arm: Arm, cutoff: float) -> Rows:
    """The rows of all recordings. Raises RecordingError where they are too short to tell anything."""
    parts, first = [], 0
    for motion in motions:
        part = _rows(motion, arm, TORQUE * cutoff, first)
        parts.append(part)
        first = int(part.block[-1]) + 1 if len(part.block) else first
    every = [
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("torque", "asked", "joint", "link", "known", "block")
    ]
    rows = Rows(*every)
    if len(np.unique(rows.block[rows.known.any(axis=1)])) < LEAST:
        raise RecordingError(
            f"too short: bodies want {LEAST} blocks of {block_length(cutoff):.3g} s in motion, or more"
        )
    return rows


def block_length(cutoff: float) -> float:
    """s: long beside the filter's memory."""
    return max(BLOCK, PERIODS / (TORQUE * cutoff))


def _rows(motion: Motion, arm: Arm, cutoff: float, first: int) -> Rows:
    step = float(motion.stamp[1] - motion.stamp[0])
    own = np.stack(motion.motor, axis=2)
    link = arm.body.last_link_shares(*motion.joint, arm.pull)
    asked = -arm.body.moments(motion.joint[0], arm.pull, arm.payload, *motion.joint[1:])
    torque, asked, own, link = (lowpass(each, step, cutoff) for each in (motion.torque, asked, own, link))
    reach = int(np.ceil(MEMORY / (cutoff * step)))
    lost = binary_dilation(~motion.known, np.ones((2 * reach + 1, 1)))
    lost[: ENDS * reach] = lost[max(len(lost) - ENDS * reach, 0) :] = True
    keep = slice(None, None, max(int(1.0 / (step * KEPT * cutoff)), 1))
    block = ((motion.stamp - motion.stamp[0]) / block_length(cutoff / TORQUE)).astype(int) + first
    return Rows(torque[keep], asked[keep], own[keep], link[keep], ~lost[keep], block[keep])
