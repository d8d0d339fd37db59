"""A joint under two names: nothing would drive it, and what it does to others would have no cause."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import SequenceMatcher

from trunk_ros.diagnosis.levels import ROUGHLY
from trunk_ros.errors import RecordingError
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import COMPARED, TOPICS


def refuse_misnamed(recording: Recording, model: Model) -> None:
    """Raise RecordingError where a joint has two names."""
    if said := misnamed(recording, model):
        raise RecordingError(f"{recording.name}: {said}")


def misnamed(recording: Recording, model: Model) -> str:
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
    best = max(names, key=lambda name: _alike(joint, name), default="")
    return best if best and _alike(joint, best) >= 1.0 - ROUGHLY else ""


def _alike(one: str, other: str) -> float:
    """How alike names are, word by word: left and right, or 1 and 2, are other joints of one arm."""
    words = [re.findall(r"\d+|[^\W\d_]+", name.lower()) for name in (one, other)]
    if all(words) and "".join(words[0]) == "".join(words[1]):
        return 1.0
    if not all(words) or len(words[0]) != len(words[1]):
        return 0.0
    pairs = zip(*words, strict=True)
    return min(SequenceMatcher(None, a, b).ratio() if a.isalpha() else float(a == b) for a, b in pairs)
