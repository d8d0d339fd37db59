"""Joint angles and the tip at the same moments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.tip.between import angles_between
from trunk_ros.model import Model
from trunk_ros.recording.recording import PoseSeries, Recording
from trunk_ros.recording.signal.resample import longest_gap

LEAST = 4  # poses of a recording


@dataclass
class TipData:
    """Tip and joint angles at the same stamps: ``tip`` (n, 3) y, z [m], roll [rad], or (n, 2) where no
    orientation was measured; ``theta`` (n, joints) rad.
    """

    arm: Arm
    stamp: Array
    theta: Array
    tip: Array


def tip_data(recording: Recording, model: Model, delay: float = 0.0) -> TipData | None:
    """What the arm stage is judged on, joint readings being ``delay`` s old; None where the tip, link
    lengths or a joint are missing. ``model``: with the physics of the wires that was found.
    """
    joints = recording.series.get("joint_states")
    if recording.tip is None or joints is None or not model.arm.is_planar:
        return None
    if not set(model.arm.joints) <= set(joints.joints):
        return None
    joints = joints.select(model.arm.joints)
    known = np.isfinite(joints.position).all(axis=1)
    if known.sum() < LEAST:
        return None
    at, pose = joints.stamp[known] - delay, recording.tip
    there, turned = _seen(at, pose.stamp) & np.isfinite(pose.position).all(axis=1), oriented(pose)
    inside = there & turned if turned.any() else there
    if inside.sum() < LEAST:
        return None
    theta = _theta(recording, model, at, joints.position[known], pose.stamp[inside])
    tip = pose.position[inside, 1:3]
    if turned.any():
        tip = np.column_stack([tip, roll_of(pose.orientation[inside], theta.sum(axis=1))])
    return TipData(model.arm, pose.stamp[inside], theta, tip)


def oriented(pose: PoseSeries) -> np.ndarray:
    """(n,) whether a pose has an orientation: one that never changes at all was not measured."""
    finite = np.isfinite(pose.orientation).all(axis=1)
    told = finite & np.any(pose.orientation != 0.0, axis=1)
    return told if told.any() and np.ptp(pose.orientation[told], axis=0).any() else np.zeros_like(told)


def roll_of(orientation: Array, heading: Array) -> Array:
    """(n,) rad turn about X of quaternions (n, 4), in the turn that is nearest to ``heading`` (n,)."""
    roll = 2.0 * np.arctan2(orientation[:, 0], orientation[:, 3])
    return np.asarray(roll + 2 * np.pi * np.round((heading - roll) / (2 * np.pi)))


def _theta(recording: Recording, model: Model, at: Array, measured: Array, stamp: Array) -> Array:
    """(n, joints) angles at ``stamp``: what the model says, and what was measured ``at`` other moments beyond
    that, which is smooth.
    """
    both = angles_between(recording, model, np.concatenate([at, stamp]))
    told = np.zeros((len(at) + len(stamp), measured.shape[1])) if both is None else both
    return np.asarray(Akima1DInterpolator(at, measured - told[: len(at)])(stamp) + told[len(at) :])


def _seen(at: Array, stamp: Array) -> np.ndarray:
    """(n,) whether samples at stamps ``at`` lie close on both sides of each of ``stamp`` (n,)."""
    before = np.clip(np.searchsorted(at, stamp, side="right") - 1, 0, len(at) - 2)
    inside = (stamp >= at[0]) & (stamp <= at[-1])
    return np.asarray(inside & (at[before + 1] - at[before] <= longest_gap(at)))
