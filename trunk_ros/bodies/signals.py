"""A recording's torque and motion, through one zero-phase filter."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from trunk_ros.arm import Arm
from trunk_ros.compiled import Array
from trunk_ros.effort import MOVES
from trunk_ros.errors import ModelError, RecordingError
from trunk_ros.model import Model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.fill import fill
from trunk_ros.recording.signal.gaps import in_gaps, runs
from trunk_ros.simulate import simulate
from trunk_ros.transmission import by_joint, ratio_of, uncoupled

ORDER = 4  # of the low-pass, which runs forward and backward
WIDE, SPEED = 5.0, 0.95  # times the frequency below which this share of the speed's power lies: the cut-off
SLOWEST = 1.0  # Hz, of a cut-off
MOST = 0.2  # of the sampling rate, of a cut-off
TORQUE = 0.5  # of that cut-off: the one that torque and regressor share (Gautier's parallel filter)
FINE = 10.0  # samples in a period of the cut-off that are computed with
KEPT = 2.5  # samples in a period of the torque's cut-off that are fitted
STANDS = 0.1  # s from which on a joint without speed stands, and its friction may be anything
LEAST = 16  # blocks: fewer say little of the uncertainty
BLOCK = 2.0  # s
PERIODS = 2.0  # of the torque's cut-off that a block has at least


@dataclass(frozen=True)
class Motion:
    """Torque and motion of one recording on an even grid; (n, joints) each, at the joints."""

    stamp: Array
    torque: Array
    """N m or N that the motors apply."""
    motor: tuple[Array, Array, Array]
    """Direction, speed and acceleration of the motors, by the ratio at the joints."""
    joint: tuple[Array, Array, Array]
    """Angle, speed and acceleration of the joints."""
    known: np.ndarray
    """(n, joints): where torque was recorded and the joint did not stand."""


def motion_of(recording: Recording, model: Model, cutoff: float) -> Motion:
    """Torque and motion of a recording below ``cutoff`` Hz.

    The motors' angles are those of ``gearbox_states``, the joints' what the model makes of them, less what is
    late or seen late in its sensors.
    """
    arm, gearbox = at_the_joints(recording, model)
    assert gearbox.effort is not None
    step = float(np.median(np.diff(gearbox.stamp)))
    grid = np.arange(gearbox.stamp[0], gearbox.stamp[-1], step)
    thin = max(int(1.0 / (step * FINE * cutoff)), 1)
    motor = _moved(grid, _even(gearbox, gearbox.position, grid) * arm.ratio, cutoff)
    joint = _moved(grid, _joint_angles(recording, model, grid), cutoff)
    torque = lowpass(_even(gearbox, gearbox.effort, grid) / arm.ratio, step, cutoff)
    way = lowpass(np.sign(motor[1]), step, cutoff)
    seen = ~in_gaps(gearbox, grid) & ~in_gaps(replace(gearbox, position=gearbox.effort), grid)
    stands = _stands(motor[1], MOVES * np.abs(arm.ratio), step)
    rows = slice(None, None, thin)
    return Motion(
        grid[rows], torque[rows], (way[rows], motor[1][rows], motor[2][rows]),
        (joint[0][rows], joint[1][rows], joint[2][rows]), (seen & ~stands)[rows],
    )  # fmt: skip


def at_the_joints(recording: Recording, model: Model) -> tuple[Arm, JointSeries]:
    """The arm with the ratio that was found, and the motors' angles and torques, one of each per joint.

    Raises RecordingError or ModelError, in one line, for what cannot be fitted.
    """
    if not model.arm.has_load:
        raise ModelError(
            "the model has no bodies: give arm.urdf with masses, or arm.link_length and arm.link_mass"
        )
    recording, model = uncoupled(by_joint(recording, model.arm), model)
    gearbox, joints = recording.require("gearbox_states"), model.arm.joints
    where = f"{recording.name}: gearbox_states"
    if absent := [joint for joint in joints if joint not in gearbox.joints]:
        raise RecordingError(
            f"{where} has no {', '.join(absent)}, but {', '.join(gearbox.joints)}: all joints of the model"
        )
    gearbox = gearbox.select(joints)
    if gearbox.effort is None:
        raise RecordingError(f"{where} has no effort: the motors' torque is what bodies are fitted to")
    for joint, position, effort in zip(joints, gearbox.position.T, gearbox.effort.T, strict=True):
        for what, values in (("position", position), ("effort", effort)):
            if np.isfinite(values).mean() < 0.5:
                raise RecordingError(f"{where}: {what} of {joint} is not a number for most of the recording")
        if not np.nanmax(np.abs(effort)) > 0.0:
            raise RecordingError(f"{where}: effort of {joint} is 0 throughout: no torque was recorded")
    return replace(model.arm, ratio=ratio_of(model)), gearbox


def usual_cutoff(recordings: list[Recording], model: Model) -> float:
    """Hz: above what the joints do, below what the noise does."""
    found = []
    for recording in recordings:
        _, gearbox = at_the_joints(recording, model)
        step = float(np.median(np.diff(gearbox.stamp)))
        grid = np.arange(gearbox.stamp[0], gearbox.stamp[-1], step)
        speed = np.gradient(_even(gearbox, gearbox.position, grid), step, axis=0)
        power = (np.abs(np.fft.rfft(speed - speed.mean(axis=0), axis=0)) ** 2).sum(axis=1).cumsum()
        if not power[-1] > 0.0:
            raise RecordingError(f"{recording.name}: no joint moves")
        dynamic = np.fft.rfftfreq(len(grid), step)[np.searchsorted(power, SPEED * power[-1])]
        found.append(float(np.clip(WIDE * dynamic, SLOWEST, MOST / step)))
    return max(found)


def lowpass(values: Array, step: float, cutoff: float) -> Array:
    """``values`` (n, …) every ``step`` s without what is faster than ``cutoff`` Hz, and without delay."""
    if cutoff >= 0.45 / step:
        return values
    return np.asarray(sosfiltfilt(butter(ORDER, cutoff, fs=1.0 / step, output="sos"), values, axis=0))


def _even(series: JointSeries, values: Array, grid: Array) -> Array:
    """(m, joints) on a grid."""
    return np.column_stack([np.interp(grid, series.stamp, column) for column in fill(values).T])


def _joint_angles(recording: Recording, model: Model, grid: Array) -> Array:
    series = {key: each for key, each in recording.series.items() if key == "gearbox_states"}
    said = simulate(replace(recording, series=series), model.prompt()).series["joint_states"]
    return _even(said, said.select(model.arm.joints).position, grid)


def _moved(grid: Array, angle: Array, cutoff: float) -> tuple[Array, Array, Array]:
    """Angle, speed and acceleration below ``cutoff`` Hz."""
    course = CubicSpline(grid, lowpass(angle, float(grid[1] - grid[0]), cutoff))
    return course(grid), course(grid, 1), course(grid, 2)


def _stands(speed: Array, least: Array, step: float) -> np.ndarray:
    """(n, joints): where a joint has no speed for longer than a reversal takes."""
    out, slow = np.zeros(speed.shape, dtype=bool), np.abs(speed) < least
    for j, column in enumerate(slow.T):
        for begin, end in runs(column):
            out[begin:end, j] = (end - begin) * step > STANDS
    return out
