"""Numbers of servos in another unit than the model file wants: what the recording says of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from operator import itemgetter
from typing import Any

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.data.align import servo_joints
from trunk_ros.data.mix_ups.pair import MixUp
from trunk_ros.errors import RecordingError
from trunk_ros.levels import ENOUGH, PART, ROWS, TENFOLD
from trunk_ros.recording.recording import Recording
from trunk_ros.servo_course import all_setpoints, servo_course


@dataclass(frozen=True)
class Unit:
    """What a number may have been written in."""

    name: str
    says: str
    wanted: str
    power: float
    times: float

    def read(self, model: ArmModel) -> ArmModel:
        """The model with the number as it is meant: ``times`` what is written, or its inverse."""
        written = np.asarray(getattr(model.arm, self.name), dtype=float)
        if not np.all(written > 0.0):
            return model
        meant: dict[str, Any] = {self.name: self.times * written**self.power}
        return replace(model, arm=replace(model.arm, **meant))


UNITS = (
    Unit("delay", "ms", "s", 1.0, 1e-3),
    Unit("tau_v", "ms", "s", 1.0, 1e-3),
    Unit("kp", "1/ms", "1/s", 1.0, 1e3),
    Unit("kp", "its inverse, in s", "1/s", -1.0, 1.0),
)


def servo_numbers(recording: Recording, model: ArmModel) -> list[MixUp]:
    """Numbers of the model's servos with which they go elsewhere than the motors did, and tenfold nearer to
    them as if written in another unit: one number, or several. Bounds would not do: servos may be slow.
    """
    if not model.says_its_servos or not {"setpoints", "gearbox_states"} <= set(recording.series):
        return []
    look = _looked(recording, model)
    if look is None:
        return []
    joints, left, size = look.joints, look.left(model), look.size
    off = left > PART * size
    if not off.any():
        return []
    for many in range(1, len(UNITS)):
        fits = []
        for units in _mixed(model, many):
            read = model
            for unit in units:
                read = unit.read(read)
            now = look.left(read)
            if np.all(TENFOLD * now[off] < left[off]) and np.all(now[~off] <= left[~off]):
                fits.append((float(np.sum(now**2)), units, read, now[off]))
        if fits:
            _, units, read, now = min(fits, key=itemgetter(0))
            which = tuple(joint for joint, one in zip(joints, off, strict=True) if one)
            return [MixUp("unit", "servo", which, _said(units, model, read, which, left[off], now))]
    return []


@dataclass(frozen=True)
class _Look:
    recording: Recording
    joints: tuple[str, ...]
    stamp: Array
    went: Array
    size: Array

    def left(self, model: ArmModel) -> Array:
        """(joints,) rad rms between where servos would have gone and where they went, but for a constant."""
        setpoints = all_setpoints(self.recording, self.joints, model)
        assert setpoints is not None
        first = np.searchsorted(setpoints.stamp, self.stamp[-1], side="right")
        asked = replace(setpoints, stamp=setpoints.stamp[:first], position=setpoints.position[:first])
        course = servo_course(asked, self.stamp, model, self.recording)
        rows = np.searchsorted(self.stamp, course.stamp)
        return np.asarray(np.nanstd(course.position - self.went[rows], axis=0))


def _looked(recording: Recording, model: ArmModel) -> _Look | None:
    """At joints whose motors moved, over as many samples as are enough."""
    try:
        joints = servo_joints(recording, model)
    except RecordingError:  # is said where it matters
        return None
    gearbox, rows = recording.require("gearbox_states").select(joints), slice(int(TENFOLD) * ROWS)
    went = gearbox.position[rows]
    moved = np.isfinite(went).any(axis=0) & (np.nanmax(went, axis=0) > np.nanmin(went, axis=0))
    if len(went) < ENOUGH or not moved.any():
        return None
    which = tuple(joint for joint, moves in zip(joints, moved, strict=True) if moves)
    return _Look(recording, which, gearbox.stamp[rows], went[:, moved], np.nanstd(went[:, moved], axis=0))


def _mixed(model: ArmModel, many: int) -> Iterator[tuple[Unit, ...]]:
    """Units that as many numbers of the model could have."""
    could = [unit for unit in UNITS if (read := unit.read(model)) is not model and _can_be(read)]
    for some in combinations(could, many):
        if len({unit.name for unit in some}) == many:
            yield some


def _can_be(model: ArmModel) -> bool:
    """Whether loops are no faster than the steps they are computed in: no servo is, and these take long."""
    return bool(np.all(np.asarray(model.arm.kp) * STEP <= 1.0))


def _said(
    units: tuple[Unit, ...],
    model: ArmModel,
    read: ArmModel,
    joints: tuple[str, ...],
    left: Array,
    now: Array,
) -> str:
    each = [
        f"servo.{u.name} = {_listed(model, u.name)} in the model file looks like {u.says}: the file wants "
        f"{u.wanted}, so write {_listed(read, u.name)}"
        for u in units
    ]
    return (
        f"{'; '.join(each)}. The model's servos are then {now.max():.2g} rad rms from {', '.join(joints)} at "
        f"most, as it is {left.max():.2g}. Correct the file and diagnose again."
    )


def _listed(model: ArmModel, name: str) -> str:
    values = np.unique(np.asarray(getattr(model.arm, name), dtype=float))
    return ", ".join(f"{value:.4g}" for value in values)
