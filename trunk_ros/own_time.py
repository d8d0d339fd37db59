"""Curves over time that have no name: their time begins with the recording that they were drawn from, and
they say nothing of another one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import AnyModel, ArmModel
from trunk_ros.effect_values import Values
from trunk_ros.effects import effect
from trunk_ros.effects.curve import ON
from trunk_ros.recording.recording import Recording

TIME = "time"


def over_own_time(model: ArmModel) -> dict[str, list[int]]:
    """Columns of each effect without a name on which it is a curve over time."""
    found = {
        name: [column for column, word in enumerate(values.get(ON, ())) if word == TIME]
        for name, values in model.effects.items()
        if not effect(name).named
    }
    return {name: columns for name, columns in found.items() if columns}


def drawn_from(model: AnyModel, *recordings: Recording) -> AnyModel:
    """The model that was fitted on recordings, which says so where it has such curves."""
    own = (*model.recordings, *(one.stamped for one in recordings)) if over_own_time(model) else ()
    return replace(model, recordings=tuple(dict.fromkeys(own)))


def held_to(model: AnyModel, *recordings: Recording) -> AnyModel:
    """The model for recordings: without curves over time that were drawn from others. One that does not say
    what it was fitted on keeps them.
    """
    if not model.recordings or {one.stamped for one in recordings} <= {*model.recordings}:
        return model
    timed = over_own_time(model)
    left = {name: _without(name, values, timed.get(name, [])) for name, values in model.effects.items()}
    return replace(model, effects={name: values for name, values in left.items() if values}, recordings=())


def left_out(recording: Recording, model: ArmModel) -> list[str]:
    """In one line what ``held_to`` leaves out."""
    timed = over_own_time(model)
    if not timed or held_to(model, recording) is model:
        return []
    joints = [model.arm.joints[column] for column in sorted({c for those in timed.values() for c in those})]
    return [
        f"the curves over time of {', '.join(joints)} are left out: they have no name, and hold for the "
        "recording that the model was fitted on"
    ]


def _without(name: str, values: Values, columns: list[int]) -> Values:
    """An effect's values without some columns; empty where none is left."""
    if not columns:
        return values
    words = [word if column not in columns else "" for column, word in enumerate(values[ON])]
    if not any(words):
        return {}
    numbers = {p.name: np.array(values[p.name]) for p in effect(name).parameters if p.name in values}
    for p in effect(name).parameters:
        if p.name in numbers:
            numbers[p.name][columns] = p.null
    return {**values, **numbers, ON: words}
