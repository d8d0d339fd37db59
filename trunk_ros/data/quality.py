"""What the data are like: rates, gaps, losses, damage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from difflib import get_close_matches
from typing import Any

import numpy as np

from trunk_ros.arm.arm import STEP
from trunk_ros.arm_model import SAMPLED, ArmModel
from trunk_ros.data.load_cells import cell_remarks
from trunk_ros.data.mix_ups import MixUp, doubtful
from trunk_ros.data.torque import torque_remarks
from trunk_ros.recording.quality import quality
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import COMPARED, SOURCES, TOPICS

FEW_SECONDS = 5.0  # s in which an arm does little of what it does


def left_out(recording: Recording, model: ArmModel) -> list[str]:
    """Joints of a topic that are not compared, since the other topic or the model lacks them."""
    compared = [recording.series[key] for key in COMPARED["wire"] if key in recording.series]
    known = compared[0].joints if model.any_joints and compared else model.arm.joints
    both = set(known).intersection(*(series.joints for series in compared))
    asked = recording.series.get("setpoints")
    unasked = [] if asked is None else [j for j in known if j in both and j not in asked.joints]
    return [
        *(
            f"{TOPICS[key]}: {', '.join(missing)} not compared: not in every topic"
            for key in COMPARED["wire"]
            if key in recording.series
            and (missing := [j for j in recording.series[key].joints if j in known and j not in both])
        ),
        *([f"{TOPICS['setpoints']}: {', '.join(unasked)} not there: servos not compared"] if unasked else []),
        *strangers(recording, model),
    ]


def strangers(recording: Recording, model: ArmModel) -> list[str]:
    """In one line the joints of a recording that a model does not know, with the nearest names that it has
    in their place; ``recording``: its motors under the names of their joints.
    """
    if model.any_joints:
        return []
    series = [recording.series[key] for key in SOURCES + COMPARED["wire"] if key in recording.series]
    there = list(dict.fromkeys(joint for each in series for joint in each.joints))
    absent = [joint for joint in model.arm.joints if joint not in there]
    strange = [joint for joint in there if joint not in (*model.arm.joints, *model.arm.motors)]
    if not strange:
        return []
    near = {joint: get_close_matches(joint, absent, 1) for joint in strange}
    named = [f"{joint} (the model's {near[joint][0]}?)" if near[joint] else joint for joint in strange]
    said = f"{', '.join(named)} left out: the model has no such joint{'s' if len(strange) > 1 else ''}"
    same = f", and no topic has its {', '.join(absent)}: if these are the same, give them one name"
    return [said + (same if absent else "")]


def brevity(recording: Recording) -> list[str]:
    """A remark on a recording, or the part of it that was asked for, that is too short to show much."""
    took = max((float(np.ptp(each.stamp)) for each in recording.series.values()), default=np.inf)
    if took >= FEW_SECONDS:
        return []
    return [
        f"{took:.2g} s show little: effects look alike, and what depends on speed, posture or time is hardly "
        "seen. Record a minute or two"
    ]


def servo_remarks(recording: Recording, model: ArmModel | None) -> list[str]:
    """What servos are taken for in a model, where that is not what a model says that says nothing of it."""
    if model is None or "setpoints" not in recording.series:
        return []
    said = []
    if model.setpoints == SAMPLED:
        said.append("taken for samples of what moves on between them (recording.setpoints)")
    if model.arm.step != STEP:
        loops = f"each {1e3 * model.arm.step:.2g} ms" if model.arm.step > 0.0 else "without steps"
        usual = f"{1e3 * STEP:.2g} ms of a model that states none"
        said.append(
            f"servos are simulated in loops that run {loops} (servo.step): no fault, but not the {usual}"
        )
    return [f"{TOPICS['setpoints']}: {one}" for one in said]


def quality_of_recording(
    recording: Recording, model: ArmModel, mixed: Sequence[MixUp] = (), found: ArmModel | None = None
) -> dict[str, Any]:
    """Rates and gaps by topic, what the reader had to say, what is mixed up, what clocks and sensors did, and
    what the motors' torque says of the load. ``found``: the model with what was found.
    """
    topics = {key: asdict(value) for key, value in quality(recording).items()}
    remarks = [one.statement for one in recording.observed]
    remarks += [f"{one.statement}." for one in mixed if not one.certain]
    remarks += cell_remarks(recording, model)
    remarks += brevity(recording)
    remarks += servo_remarks(recording, found)
    torque = torque_remarks(recording, model, found)
    odd = [*left_out(recording, model), *doubtful(recording, model, mixed)]
    notes = [*recording.notes, *odd, *torque, *remarks]
    return {
        "duration": recording.duration,
        **({} if recording.asked is None else dict(zip(("from", "until"), recording.asked, strict=True))),
        "topics": topics,
        "notes": notes,
        "mix_ups": [{**asdict(one), "joints": list(one.joints)} for one in mixed],
        "observed": [asdict(one) for one in recording.observed],
    }


def quality_by_name(
    recordings: list[Recording], model: ArmModel, mixed: Sequence[list[MixUp]], fitted: ArmModel
) -> dict[str, Any]:
    """The same by name of recording; those of one name are numbered."""
    out: dict[str, Any] = {}
    for number, recording in enumerate(recordings, start=1):
        name = recording.name if recording.name not in out else f"{recording.name} ({number})"
        found = mixed[number - 1] if mixed else []
        out[name] = quality_of_recording(recording, model, found, fitted)
    return out
