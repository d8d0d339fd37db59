"""A joint under two names: nothing would drive it, and what it does to others would have no cause."""

from __future__ import annotations

import re
from collections.abc import Iterable

from trunk_ros.arm_model import ArmModel
from trunk_ros.errors import RecordingError
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import COMPARED, TOPICS


def refuse_misnamed(recording: Recording, model: ArmModel) -> None:
    """Raise RecordingError where a joint has two names."""
    if said := misnamed(recording, model):
        raise RecordingError(f"{recording.name}: {said}")


def misnamed(recording: Recording, model: ArmModel) -> str:
    """In one line the first joint of the model (of the motors, where that is for any joints) that a topic
    lacks which has one of nearly that name; ``recording``: its motors under the names of their joints.
    """
    topics = [key for key in (*COMPARED["wire"], "setpoints") if key in recording.series]
    if not topics:
        return ""
    of_model = not model.any_joints
    known = model.arm.joints if of_model else recording.series[topics[0]].joints
    others = model.arm.motors if of_model else ()
    owner = "the model's joint" if of_model else f"{TOPICS[topics[0]]}' joint"
    for key in topics:
        there = recording.series[key].joints
        strange = [joint for joint in there if joint not in (*known, *others)]
        for joint in (joint for joint in known if joint not in there):
            if near := _nearest(joint, strange):
                return f"{owner} {joint!r} is not in {TOPICS[key]}, which has {near!r}: rename one of them"
    return ""


def _nearest(joint: str, names: Iterable[str]) -> str:
    """The one of ``names`` that is ``joint`` but for spelling, "" where none is."""
    return next((name for name in names if _is_alike(joint, name)), "")


def _is_alike(one: str, other: str) -> bool:
    """Whether names differ by capitals and separators, or by a slip of the pen in one word: left and right,
    or 1 and 2, are other joints of one arm, and so may be what begins or ends with another letter.
    """
    words = [re.findall(r"\d+|[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name) for name in (one, other)]
    mine, theirs = ([int(w) if w.isdigit() else w.lower() for w in each] for each in words)
    numbers = [[w for w in each if isinstance(w, int)] for each in (mine, theirs)]
    if "".join(map(str, mine)) == "".join(map(str, theirs)) and numbers[0] == numbers[1]:
        return bool(mine)
    differ = [(a, b) for a, b in zip(mine, theirs, strict=False) if a != b]
    return len(mine) == len(theirs) and len(differ) == 1 and _is_slip(*map(str, differ[0]))


def _is_slip(one: str, other: str) -> bool:
    """Whether two words are one but for a letter too many within, or two in each other's place; of more than
    five letters also but for another one: waist and wrist are two.
    """
    if min(len(one), len(other)) <= 2 or (one[0], one[-1]) != (other[0], other[-1]):
        return False
    if len(one) != len(other):
        short, long = sorted((one, other), key=len)
        return short in (long[:k] + long[k + 1 :] for k in range(len(long)))
    differ = [k for k, (a, b) in enumerate(zip(one, other, strict=True)) if a != b]
    if len(differ) == 1:
        return len(one) > 5
    return len(differ) == 2 and differ[1] - differ[0] == 1 and sorted(one) == sorted(other)
