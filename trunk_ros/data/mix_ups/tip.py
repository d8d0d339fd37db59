"""Poses of the tip in another unit, in a frame that is turned, or with another order of their quaternion."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.pair import Kind, MixUp
from trunk_ros.levels import FEWEST, HALF, ROWS, TENFOLD
from trunk_ros.recording.recording import PoseSeries, Recording
from trunk_ros.recording.topics import TIP_TOPIC

UNITS = {"m": 1.0, "mm": 1e3}
ORDERS = {"w, x, y, z": np.array([1, 2, 3, 0])}


def tip_mixed(recording: Recording, model: ArmModel) -> list[MixUp]:
    """What is mixed up in the tip's poses, where they are far from what the joints' readings and the model's
    links say, and ten times as near after one such change. Where the base stands says nothing here.
    """
    pose, joints, arm = recording.tip, recording.series.get("joint_states"), model.arm
    if pose is None or joints is None or not arm.has_geometry or not {*arm.joints} <= {*joints.joints}:
        return []
    shown = joints.select(arm.joints)
    known = np.isfinite(shown.position).all(axis=1)
    told = np.isfinite(pose.position).all(axis=1) & np.isfinite(pose.orientation).all(axis=1)
    if min(known.sum(), told.sum()) < FEWEST:
        return []
    some = np.flatnonzero(told)[:: max(int(told.sum()) // ROWS, 1)]
    seen = PoseSeries(pose.stamp[some], pose.position[some], pose.orientation[some])
    at = shown.stamp[known]
    theta = np.column_stack([np.interp(seen.stamp, at, one) for one in shown.position[known].T])
    said = [
        *_placed(seen.position, arm.tip(theta)[:, :3]),
        *_ordered(seen.orientation, arm.tip(theta)[:, 3:]),
    ]
    return [MixUp(kind, "arm", arm.joints, f"{TIP_TOPIC}{text} and diagnose again.") for kind, text in said]


def _placed(seen: Array, there: Array) -> list[tuple[Kind, str]]:
    """By places (n, 3) m, wherever the base is."""
    seen, there = seen - seen.mean(axis=0), there - there.mean(axis=0)
    left = {(unit, k): np.linalg.norm(seen / size - there @ turn.T) * size
            for (unit, size), (k, turn) in product(UNITS.items(), enumerate(QUARTERS))}  # fmt: skip
    unit, k = min(left, key=lambda way: left[way])
    as_it_is = left["m", 0]
    if as_it_is < HALF * np.linalg.norm(there) or TENFOLD * left[unit, k] > as_it_is:
        return []
    out: list[tuple[Kind, str]] = []
    if unit != "m":
        out.append(
            ("unit", f" looks like {unit}: it goes as far in them as the links do in m. Convert it to m,")
        )
    if k:
        about = ", ".join(f"{value:.0f}" for value in Rotation.from_matrix(QUARTERS[k]).as_euler("xyz", True))
        out.append(("order", f" is in a frame that is turned: by {about} degrees (roll, pitch, yaw) from the "
                             "model's base. Turn it back, or turn the model's,"))  # fmt: skip
    return out


def _ordered(seen: Array, there: Array) -> list[tuple[Kind, str]]:
    """By orientations (n, 4), however the base or the tool is turned."""
    if not np.ptp(seen, axis=0).any() or not np.linalg.norm(seen, axis=1).all():
        return []
    as_it_is = _apart(seen, there)
    if as_it_is < HALF * _apart(there[:1].repeat(len(there), axis=0), there):
        return []
    return [
        ("order", f": its quaternions look like {name}. Write them as x, y, z, w,")
        for name, order in ORDERS.items()
        if TENFOLD * _apart(seen[:, order], there) < as_it_is
    ]


def _apart(seen: Array, there: Array) -> float:
    """rad, root of the sum of squares, that orientations (n, 4) are apart but for a turn of the base, or of
    the tool.
    """
    one, other = Rotation.from_quat(seen), Rotation.from_quat(there)
    based, tooled = one * other.inv(), other.inv() * one
    return float(min(np.linalg.norm((turn[0].inv() * turn).magnitude()) for turn in (based, tooled)))


def _quarters() -> list[Array]:
    """The 24 rotations by quarter turns, the least first."""
    signed = [np.eye(3)[list(p)] * s for p in permutations(range(3)) for s in product((1.0, -1.0), repeat=3)]
    return sorted((m for m in signed if np.linalg.det(m) > 0.0), key=lambda m: -float(np.trace(m)))


QUARTERS = _quarters()
