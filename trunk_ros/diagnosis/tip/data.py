"""Joint angles and the tip at the same moments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import Akima1DInterpolator
from scipy.spatial.transform import Rotation

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.derivatives import smooth
from trunk_ros.diagnosis.tip.between import angles_between
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording
from trunk_ros.recording.signal.encoder import counts
from trunk_ros.recording.signal.resample import longest_gap

UNITS = {"x": "m", "y": "m", "z": "m", "roll": "rad", "pitch": "rad", "yaw": "rad"}
SIGNALS = tuple(UNITS)
IN_PLANE = ("y", "z", "roll")
POSES = 4  # poses of a recording


@dataclass
class TipData:
    """Tip and joint angles at the same stamps: ``pose`` (n, 7) x, y, z [m] and quaternion x, y, z, w, which
    says something only where it is ``oriented``; ``theta`` (n, joints) rad.
    """

    arm: Arm
    stamp: Array
    theta: Array
    pose: Array
    oriented: bool

    @cached_property
    def load(self) -> Array:
        """(n, joints) N m of the weight."""
        return self.arm.load(self.theta)

    @cached_property
    def speed(self) -> Array:
        """(n, joints) rad/s."""
        return smooth(self.stamp, self.theta)[1]

    def off(self, pose: Array) -> Array:
        """(n, 6) measured less predicted ``pose`` (n, 7): m along, rad about the axes of the base link."""
        if not self.oriented:
            return np.column_stack([self.pose[:, :3] - pose[:, :3], np.zeros((len(pose), 3))])
        turn = Rotation.from_quat(self.pose[:, 3:]) * Rotation.from_quat(pose[:, 3:]).inv()
        return np.column_stack([self.pose[:, :3] - pose[:, :3], turn.as_rotvec()])

    @cached_property
    def seen(self) -> Array:
        """(n, 6) place [m] and rotation vector [rad] of the poses."""
        turn = Rotation.from_quat(self.pose[:, 3:]).as_rotvec() if self.oriented else 0.0 * self.pose[:, :3]
        return np.column_stack([self.pose[:, :3], turn])

    def rows(self, keep: np.ndarray) -> TipData:
        """Some of the poses."""
        return TipData(self.arm, self.stamp[keep], self.theta[keep], self.pose[keep], self.oriented)


def signals_of(data: Sequence[TipData]) -> tuple[str, ...]:
    """What is compared: of a chain in a plane what lies in it, without orientations only places."""
    told = IN_PLANE if data[0].arm.is_planar else SIGNALS
    return tuple(s for s in told if UNITS[s] == "m" or all(d.oriented for d in data))


def tip_data(recording: Recording, model: Model, delay: float = 0.0) -> TipData | None:
    """What the arm stage is judged on, joint readings being ``delay`` s old; None where the tip, links
    or a joint are missing. ``model``: with the physics of the wires that was found.
    """
    joints = recording.series.get("joint_states")
    if recording.tip is None or joints is None or not model.arm.has_geometry:
        return None
    if not set(model.arm.joints) <= set(joints.joints):
        return None
    joints = joints.select(model.arm.joints)
    known = np.isfinite(joints.position).all(axis=1)
    if known.sum() < POSES:
        return None
    at, pose = joints.stamp[known] - delay, recording.tip
    there, turned = _seen(at, pose.stamp) & np.isfinite(pose.position).all(axis=1), oriented(pose)
    inside = there & turned if turned.any() else there
    if inside.sum() < POSES:
        return None
    theta = _theta(recording, model, at, joints.rows(np.asarray(known)), pose.stamp[inside])
    poses = np.column_stack([pose.position[inside], pose.orientation[inside]])
    return TipData(model.arm, pose.stamp[inside], theta, poses, bool(turned.any()))


def oriented(pose: PoseSeries) -> np.ndarray:
    """(n,) whether a pose has an orientation: one that never changes at all was not measured."""
    finite = np.isfinite(pose.orientation).all(axis=1)
    told = finite & np.any(pose.orientation != 0.0, axis=1)
    return told if told.any() and np.ptp(pose.orientation[told], axis=0).any() else np.zeros_like(told)


def _theta(recording: Recording, model: Model, at: Array, shown: JointSeries, stamp: Array) -> Array:
    """(n, joints) angles at ``stamp``: what the model says, and what was ``shown`` at other moments, ``at``,
    beyond that, which is smooth. Within an encoder's count a reading says no more than the model does.
    """
    both = angles_between(recording, model, np.concatenate([at, stamp]))
    if both is None:
        return np.asarray(Akima1DInterpolator(at, shown.position)(stamp))
    beyond, within = shown.position - both[: len(at)], 0.5 * counts(shown)
    return np.asarray(
        Akima1DInterpolator(at, beyond - np.clip(beyond, -within, within))(stamp) + both[len(at) :]
    )


def _seen(at: Array, stamp: Array) -> np.ndarray:
    """(n,) whether samples at stamps ``at`` lie close on both sides of each of ``stamp`` (n,)."""
    before = np.clip(np.searchsorted(at, stamp, side="right") - 1, 0, len(at) - 2)
    inside = (stamp >= at[0]) & (stamp <= at[-1])
    return np.asarray(inside & (at[before + 1] - at[before] <= longest_gap(at)))
