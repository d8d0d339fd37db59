"""Recordings with what clocks, units and sensors did to them taken back, as far as that is certain."""

from __future__ import annotations

from dataclasses import replace

from trunk_ros.arm_model import ArmModel
from trunk_ros.data.mix_ups import MixUp, mix_ups, without_mix_ups, without_torque
from trunk_ros.data.names import refuse_misnamed
from trunk_ros.data.rests import one_of_each_rest
from trunk_ros.data.sensing.clocks import clocks_put_right
from trunk_ros.data.sensing.readings import readings_put_right
from trunk_ros.data.sensor_faults import without_faults
from trunk_ros.recording.recording import Recording
from trunk_ros.transmission import by_joint, by_motor


def put_right(recordings: list[Recording], model: ArmModel) -> tuple[list[Recording], list[list[MixUp]]]:
    """The recordings, and what is mixed up in each and left out of it; motors under the names of joints.

    Raises RecordingError where a joint has two names.
    """
    named = [one_of_each_rest(by_joint(r, model.arm)) for r in recordings]
    for recording in named:
        refuse_misnamed(recording, model)
    read = [without_faults(readings_put_right(r, model)) for r in named]
    del named
    mixed = [mix_ups(r, model) for r in read]
    read = [without_mix_ups(r, found) for r, found in zip(read, mixed, strict=True)]
    return [clocks_put_right(r, model) for r in read], mixed


def as_diagnosed(recording: Recording, model: ArmModel) -> Recording:
    """The recording with the readings that a diagnosis compares with the model's arm, motors under the names
    that they had.

    Effects of the model have no say in it: what it lacks, or has too much of, stays an error. What is mixed
    up stays as it is, and clocks with it, as they are told by units and names that are right.
    """
    bare = replace(model, effects={})
    right = without_faults(readings_put_right(one_of_each_rest(by_joint(recording, bare.arm)), bare))
    found = mix_ups(right, bare)
    right, mixed = without_torque(right, found), [one for one in found if one.certain and one.stage != "arm"]
    if mixed:
        joints = ", ".join(dict.fromkeys(joint for one in mixed for joint in one.joints))
        note = f"{joints}: mixed up, and taken as recorded, as are all stamps; diagnose says what it is"
        return by_motor(replace(right, notes=(*right.notes, note)), recording, bare.arm)
    return by_motor(clocks_put_right(right, bare), recording, bare.arm)


def said_of(recording: Recording) -> list[str]:
    """In a line each what was left out of a recording, and what of it was put right."""
    return [*recording.notes, *(one.statement for one in recording.observed if one.corrected)]
