"""What the data are like: rates, gaps, losses, damage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from trunk_ros.diagnosis.data.load_cells import cell_remarks
from trunk_ros.diagnosis.data.mix_ups import MixUp
from trunk_ros.diagnosis.data.torque import torque_remarks
from trunk_ros.model import Model
from trunk_ros.recording.quality import quality
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.topics import COMPARED, TOPICS


def left_out(recording: Recording, model: Model) -> list[str]:
    """Joints of a topic that are not compared, since the other topic or the model lacks them."""
    compared = [recording.series[key] for key in COMPARED["wire"] if key in recording.series]
    known = compared[0].joints if model.any_joints and compared else model.arm.joints
    both = set(known).intersection(*(series.joints for series in compared))
    asked = recording.series.get("setpoints")
    unasked = [] if asked is None else [j for j in known if j in both and j not in asked.joints]
    return [
        *(
            f"{TOPICS[key]}: {', '.join(missing)} not compared: not in every topic and in the model"
            for key in COMPARED["wire"]
            if key in recording.series
            and (missing := [j for j in recording.series[key].joints if j not in both])
        ),
        *([f"{TOPICS['setpoints']}: {', '.join(unasked)} not there: servos not compared"] if unasked else []),
        *_other_names(compared, () if model.any_joints else known),
    ]


def _other_names(compared: Sequence[JointSeries], known: Sequence[str]) -> list[str]:
    """Joints of the model that no topic has, beside joints of topics that the model does not have."""
    there = {joint: None for series in compared for joint in series.joints}
    absent = [joint for joint in known if joint not in there]
    strange = [joint for joint in there if joint not in known]
    if not absent or not strange or not known:
        return []
    return [
        f"the model's {', '.join(absent)} {'is' if len(absent) == 1 else 'are'} in no topic, which have "
        f"{', '.join(strange)}: if these are the same, give them one name"
    ]


def quality_of_recording(recording: Recording, model: Model, mixed: Sequence[MixUp] = ()) -> dict[str, Any]:
    """Rates and gaps by topic, what the reader had to say, what is mixed up, what clocks and sensors did, and
    what the motors' torque says of the load.
    """
    topics = {key: asdict(value) for key, value in quality(recording).items()}
    remarks = [one.statement for one in recording.observed]
    remarks += [f"{one.statement}." for one in mixed if not one.certain]
    remarks += cell_remarks(recording, model)
    notes = [*recording.notes, *left_out(recording, model), *torque_remarks(recording, model), *remarks]
    return {
        "duration": recording.duration,
        "topics": topics,
        "notes": notes,
        "mix_ups": [{**asdict(one), "joints": list(one.joints)} for one in mixed],
        "observed": [asdict(one) for one in recording.observed],
    }
