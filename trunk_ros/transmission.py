"""Motors that move several joints: their recorded angles and torques, as the joints' own wires have them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm_model import AnyModel, ArmModel
from trunk_ros.compiled import Array
from trunk_ros.errors import RecordingError
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.encoder import between_counts, counts

OF_MOTORS = ("gearbox_states", "setpoints")


def by_joint(recording: Recording, arm: Arm) -> Recording:
    """The recording with each motor under the name of the joint in its row of the model."""
    series = dict(recording.series)
    for key in OF_MOTORS:
        if arm.motors and key in series and set(arm.motors) <= set(series[key].joints):
            series[key] = replace(series[key].select(arm.motors), joints=arm.joints)
    return replace(recording, series=series)


def by_motor(recording: Recording, named: Recording, arm: Arm) -> Recording:
    """What ``by_joint`` made of the recording ``named``, with each motor under its own name again."""
    series = dict(recording.series)
    for key in OF_MOTORS:
        if arm.motors and key in series and set(arm.motors) <= set(named.series[key].joints):
            series[key] = replace(series[key], joints=arm.motors)
    return replace(recording, series=series)


def uncoupled(recording: Recording, model: AnyModel) -> tuple[Recording, AnyModel]:
    """Both as if each joint had a motor of its own, which turns as far as all motors together turn the joint.

    Raises RecordingError where a motor is missing.
    """
    arm = model.arm
    if arm.coupling is None:
        return recording, model
    series = dict(recording.series)
    for key in OF_MOTORS:
        if key in series:
            if missing := [joint for joint in arm.joints if joint not in series[key].joints]:
                raise RecordingError(
                    f"{recording.name}: {key} has no {', '.join(missing)}: wire.coupling wants all motors"
                )
            series[key] = at_joints(series[key].select(arm.joints), arm, key == "gearbox_states")
    return replace(recording, series=series), replace(model, arm=arm.uncoupled())


def at_joints(series: JointSeries, arm: Arm, measured: bool = True) -> JointSeries:
    """Angles, speeds and torques of motors as the joints' wires have them; of ``measured`` angles those
    between the encoders' steps, which cannot be seen any more afterwards.
    """
    if arm.coupling is None:
        return series
    if measured:
        series = between_counts(series, counts(series))
    back = np.linalg.inv(arm.coupling)
    return JointSeries(
        series.stamp,
        arm.joints,
        arm.driven(series.position),
        None if series.velocity is None else arm.driven(series.velocity),
        None if series.effort is None else series.effort @ back,
    )


def ratio_of(model: ArmModel) -> Array:
    """(joints,) joint angle per gearbox angle, with what was found."""
    return np.asarray(model.number("ratio"))
