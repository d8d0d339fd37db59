"""Recordings with what clocks, units and sensors did to them taken back, as far as that is certain."""

from __future__ import annotations

from trunk_ros.diagnosis.data.mix_ups import MixUp, mix_ups, without_mix_ups
from trunk_ros.diagnosis.data.names import refuse_misnamed
from trunk_ros.diagnosis.data.sensing.clocks import clocks_put_right
from trunk_ros.diagnosis.data.sensing.readings import readings_put_right
from trunk_ros.diagnosis.data.sensor_faults import without_faults
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.transmission import by_joint


def put_right(recordings: list[Recording], model: Model) -> tuple[list[Recording], list[list[MixUp]]]:
    """The recordings, and what is mixed up in each and left out of it; motors under the names of joints.

    Raises RecordingError where a joint has two names.
    """
    named = [by_joint(r, model.arm) for r in recordings]
    for recording in named:
        refuse_misnamed(recording, model)
    read = [without_faults(readings_put_right(r, model)) for r in named]
    del named
    mixed = [mix_ups(r, model) for r in read]
    read = [without_mix_ups(r, found) for r, found in zip(read, mixed, strict=True)]
    return [clocks_put_right(r, model) for r in read], mixed
