"""One signal of a recording beside what was predicted for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.tip.data import oriented
from trunk_ros.recording.recording import JointSeries, PoseSeries
from trunk_ros.recording.signal.gaps import in_gaps
from trunk_ros.recording.signal.measured import Measured
from trunk_ros.recording.signal.resample import longest_gap

STILL = 1e-6  # m that a tip may move along an axis that nothing moves it along


@dataclass(frozen=True)
class Signal(Measured):
    """With ``error`` (n,), measured less predicted, NaN where one of them is not known."""

    error: Array


def of_joints(
    stage: str, measured: JointSeries, predicted: JointSeries, units: dict[str, str]
) -> list[Signal]:
    """A signal for each joint that both have; predictions are brought to the measured stamps."""
    joints = tuple(joint for joint in measured.joints if joint in predicted.joints)
    measured, predicted = measured.select(joints), predicted.select(joints)
    lost = in_gaps(predicted, measured.stamp)
    out = []
    for j, joint in enumerate(joints):
        there = at_stamps(predicted.stamp, predicted.position[:, j], measured.stamp)
        error = np.where(lost[:, j], np.nan, measured.position[:, j] - there)
        out.append(
            Signal(stage, joint, units.get(joint, "rad"), measured.stamp, measured.position[:, j], error)
        )
    return out


def of_tip(measured: PoseSeries, predicted: PoseSeries) -> list[Signal]:
    """Position along each axis that the tip moves along, and its turn about X, of two recorded tips."""
    out = []
    for axis, name in enumerate("xyz"):
        here, there = measured.position[:, axis], predicted.position[:, axis]
        if np.nanmax(here) - np.nanmin(here) > STILL or np.nanmax(there) - np.nanmin(there) > STILL:
            error = here - at_stamps(predicted.stamp, there, measured.stamp)
            out.append(Signal("arm", name, "m", measured.stamp, here, error))
    if oriented(measured).any() and oriented(predicted).any():
        mine, theirs = (roll(pose) for pose in (measured, predicted))
        error = mine - at_stamps(predicted.stamp, theirs, measured.stamp)
        error -= 2 * np.pi * np.round(error / (2 * np.pi))
        out.append(Signal("arm", "roll", "rad", measured.stamp, mine, error))
    return out


def roll(pose: PoseSeries) -> Array:
    """(n,) rad turn about X, without jumps; NaN where no orientation was measured."""
    told = oriented(pose)
    out = np.full(len(pose.stamp), np.nan)
    out[told] = np.unwrap(2.0 * np.arctan2(pose.orientation[told, 0], pose.orientation[told, 3]))
    return out


def at_stamps(stamp: Array, values: Array, wanted: Array) -> Array:
    """Values (m,) at other stamps (n,); NaN before the first, after the last, and in gaps."""
    known = np.isfinite(values)
    if known.sum() < 2:
        return np.full(len(wanted), np.nan)
    at, out = stamp[known], np.interp(wanted, stamp[known], values[known], np.nan, np.nan)
    after = np.clip(np.searchsorted(at, wanted, side="left"), 1, len(at) - 1)
    out[(at[after] - at[after - 1] > longest_gap(stamp)) & (wanted != at[after])] = np.nan
    return np.asarray(out)
