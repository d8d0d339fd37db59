"""Effort of motors that is no torque: a magnitude, as of unsigned currents, or one with a turned sign."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.align import common_joints
from trunk_ros.data.mix_ups.pair import Kind, MixUp
from trunk_ros.effort import measured_load
from trunk_ros.errors import RecordingError
from trunk_ros.levels import OUTLIERS, PART, ROUGH, SEVERAL, SLIGHT
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import TOPICS

GEARBOX = "gearbox_states"


def no_torque(recording: Recording, model: ArmModel) -> list[MixUp]:
    """Remarks on effort that is never negative, where joints go both ways by it and it shows no friction, and
    on effort whose friction would drive them.
    """
    series = recording.series.get(GEARBOX)
    if series is None or series.effort is None:
        return []
    try:
        joints = common_joints(recording, model, series)
    except RecordingError:  # is said where it matters
        return []
    series, arm = series.select(joints), model.for_joints(joints).loaded_arm().only(joints)
    if series.effort is None:
        return []
    size = np.sqrt(np.mean(np.nan_to_num(series.effort) ** 2, axis=0))
    friction = measured_load(series, arm.ratio, arm).friction / np.where(size > 0.0, size, np.inf)
    drives = friction < -PART
    unsigned = np.array([_is_unsigned(column) for column in series.effort.T])
    if not (unsigned & drives).any() and (unsigned & (friction < PART)).sum() < SEVERAL:
        unsigned[:] = False
    kinds: tuple[tuple[Kind, np.ndarray, str], ...] = (
        ("magnitude", unsigned, "is never negative, whichever way the joints go: it is a magnitude, as of a "
         "current without a sign. It counts neither as a torque nor as a load. Give it its sign in the "
         "driver or the mapping, or leave it out"),
        ("sign", drives & ~unsigned, "acts against the motion, where a motor has to overcome friction: its "
         "sign is turned, or it is no torque. Turn it in the driver or the mapping, or leave the effort out"),
    )  # fmt: skip
    return [_remark(kind, joints, which, text) for kind, which, text in kinds if which.any()]


def without_torque(recording: Recording, found: list[MixUp]) -> Recording:
    """The recording without effort that is a magnitude; one with a turned sign stays as it is."""
    lost = {joint for one in found if one.kind == "magnitude" for joint in one.joints}
    if not lost:
        return recording
    series = recording.series[GEARBOX]
    assert series.effort is not None
    effort = series.effort.copy()
    effort[:, [series.joints.index(joint) for joint in lost]] = np.nan
    known = effort if np.isfinite(effort).any() else None
    return replace(recording, series={**recording.series, GEARBOX: replace(series, effort=known)})


def _remark(kind: Kind, joints: tuple[str, ...], which: np.ndarray, text: str) -> MixUp:
    names = tuple(joint for joint, one in zip(joints, which, strict=True) if one)
    said = f"effort of {TOPICS[GEARBOX]} of {', '.join(names)} {text}"
    return MixUp(kind, "servo", names, said, certain=False)


def _is_unsigned(effort: Array) -> bool:
    """Whether effort (n,) N m comes to nothing, often, and never goes below."""
    known = effort[np.isfinite(effort)]
    if not len(known) or known.min() < 0.0:
        return False
    low, high = np.quantile(known, [SLIGHT, 1.0 - OUTLIERS])
    return bool(known.min() < ROUGH * high and low < PART * high)
