"""What the data are like: rates, gaps, losses, damage."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from trunk_ros.diagnosis.torque import torque_remarks
from trunk_ros.model import Model
from trunk_ros.recording.quality import quality
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import TOPICS

COMPARED = ("gearbox_states", "joint_states")


def left_out(recording: Recording, model: Model) -> list[str]:
    """Joints of a topic that are not compared, since the other topic or the model lacks them."""
    compared = [recording.series[key] for key in COMPARED if key in recording.series]
    known = () if model.any_joints else (model.arm.joints,)
    everywhere = [set(series.joints) for series in compared] + [set(joints) for joints in known]
    both = set.intersection(*everywhere) if everywhere else set()
    return [
        f"{TOPICS[key]}: {', '.join(missing)} not compared: not in every topic and in the model"
        for key in COMPARED
        if key in recording.series and (missing := [j for j in recording.series[key].joints if j not in both])
    ]


def quality_of_recording(recording: Recording, model: Model) -> dict[str, Any]:
    """Rates and gaps by topic, what the reader had to say, and what the motors' torque says of the load."""
    topics = {key: asdict(value) for key, value in quality(recording).items()}
    notes = [*recording.notes, *left_out(recording, model), *torque_remarks(recording, model)]
    return {"duration": recording.duration, "topics": topics, "notes": notes}
