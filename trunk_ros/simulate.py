"""A model run over a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.data.align import common_joints
from trunk_ros.data.repeated_readings import new_motor_readings
from trunk_ros.data.sensing import turns_counted_on
from trunk_ros.data.sensor_faults import without_wild
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.encoder import between_counts, counts
from trunk_ros.recording.signal.gaps import bridged, missing
from trunk_ros.recording.signal.resample import SAME, joint_grid, resample
from trunk_ros.resistance import resistance
from trunk_ros.servo_course import LOST, all_setpoints, as_the_servo_went, servo_course
from trunk_ros.start import SETTLE, Driven, begun, first_rows
from trunk_ros.transmission import at_joints, by_joint, uncoupled


def simulate(
    recording: Recording, model: ArmModel, source: str = "gearbox_states", settle: float = SETTLE
) -> Recording:
    """What a model predicts for a recording's gearbox angles or setpoints. Of recorded joint angles those
    of the first ``settle`` s are read, to tell how the wires lay as it began and whether zeros have moved
    since the model was fitted; 0: none, memory begins at its centre.

    Stamps are those of the recorded ``joint_states``, else of the source; turns of angles that wrap are
    counted on. A model with effects is run on
    gearbox angles between the encoder's counts. Raises RecordingError where the
    source is missing.
    """
    recording = turns_counted_on(by_joint(without_wild(recording), model.arm))
    if source == "gearbox_states":
        recording, model = uncoupled(recording, model)
    given = recording.require(source)
    joints = common_joints(recording, model, given)
    given, model = given.select(joints), model.for_joints(joints)
    measured = recording.series.get("joint_states")
    shown_at = given.stamp if measured is None else measured.stamp
    series: dict[str, JointSeries] = {}
    if source == "setpoints":
        setpoints = all_setpoints(recording, joints, model)
        assert setpoints is not None
        wanted = recording.series.get("gearbox_states", given).stamp
        grid, rows, kept = joint_grid(wanted, shown_at, beyond=True)
        driven = servo_course(setpoints, grid, model, recording)
        phi = resample(driven, grid)[0]
        there = phi[np.clip(np.searchsorted(grid, wanted - SAME), 0, len(grid) - 1)]
        series["gearbox_states"] = JointSeries(wanted, model.only(joints).arm.motor_names, there)
        driven, model = (
            at_joints(driven, model.arm, measured=False),
            replace(model, arm=model.arm.uncoupled()),
        )
        phi, velocity = resample(driven, grid)
    else:
        given = new_motor_readings(given, measured)[0]
        steps = counts(given) if model.effects else np.zeros(len(joints))
        driven = _as_driven(recording, given, steps, model)
        grid, rows, kept = joint_grid(driven.stamp, shown_at, beyond=True)
        phi, velocity = resample(driven, grid)
        if model.effects:
            phi = as_the_servo_went(recording, given, steps, grid, phi, model)
    model = model.only(joints)
    known = resistance(model.arm, driven, grid, phi, measured)
    chain, state, zero = Chain(model, "wire"), None, np.zeros(len(joints))
    if measured is not None and set(joints) & set(measured.joints):
        seen = first_rows(measured.stamp[kept], settle)
        first = Driven(phi, grid, rows[:seen], _readings(measured, joints)[kept][:seen], velocity, known)
        state, zero = begun(chain, first)
    theta, _ = chain.run(phi, grid, state, velocity, known)
    series["joint_states"] = JointSeries(shown_at[kept], joints, theta[rows] + zero)
    return Recording(recording.name, recording.start_ns, recording.duration, series, units=recording.units)


def _readings(measured: JointSeries, joints: tuple[str, ...]) -> Array:
    """(n, joints) measured angles, NaN for joints that were not."""
    out = np.full((len(measured.stamp), len(joints)), np.nan)
    for k, joint in enumerate(joints):
        if joint in measured.joints:
            out[:, k] = measured.position[:, measured.joints.index(joint)]
    return out


def _as_driven(recording: Recording, gearbox: JointSeries, steps: Array, model: ArmModel) -> JointSeries:
    """Gearbox angles between the encoder's counts, and with lost ones as the servo follows the setpoints.

    A model without effects stays the formula of the counts.
    """
    if model.effects:
        gearbox = between_counts(gearbox, steps)
    setpoints = all_setpoints(recording, gearbox.joints, model)
    if setpoints is None or not model.says_its_servos:
        return bridged(gearbox, longest=LOST)
    lost = missing(gearbox.stamp, end=float(recording.series["setpoints"].stamp[-1]))
    if not len(lost):
        return gearbox
    return bridged(gearbox, servo_course(setpoints, np.union1d(gearbox.stamp, lost), model, recording))
