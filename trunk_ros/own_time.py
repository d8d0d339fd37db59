"""Curves over time that have no name: their time begins with the recording that they were drawn from, and
nothing says that another one repeats it.
"""

from __future__ import annotations

from dataclasses import replace

from trunk_ros.arm_model import AnyModel, ArmModel
from trunk_ros.effects import effect
from trunk_ros.effects.curve import ON
from trunk_ros.recording.identity import is_one_of
from trunk_ros.recording.recording import Recording

TIME = "time"


def drawn_from(model: AnyModel, *recordings: Recording) -> AnyModel:
    """The model that was fitted on recordings, which says so where it has such curves."""
    own = (*model.recordings, *(one.stamped for one in recordings)) if _over_own_time(model) else ()
    return replace(model, recordings=tuple(dict.fromkeys(own)))


def doubtful_curves(recording: Recording, model: ArmModel) -> list[str]:
    """In one line which curves were drawn from other recordings than this one; none where the model does not
    say from which.
    """
    if not model.recordings or is_one_of(recording.stamped, model.recordings):
        return []
    joints = [model.arm.joints[column] for column in sorted(_over_own_time(model))]
    return [
        f"the curves over time of {', '.join(joints)} have no name, and were drawn from another recording: "
        "whether this one repeats them is not known"
    ] * bool(joints)


def _over_own_time(model: ArmModel) -> set[int]:
    """The columns that have such a curve."""
    curves = [values.get(ON, ()) for name, values in model.effects.items() if not effect(name).named]
    return {column for words in curves for column, word in enumerate(words) if word == TIME}
