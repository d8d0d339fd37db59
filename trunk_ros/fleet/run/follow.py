"""The second task: the effects that an arm has are fitted to one of its recordings, whether they were found
in it or not, so that what grows is followed from its beginning.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.data.align import servo_span, wire_span
from trunk_ros.data.sensor_faults import without_faults
from trunk_ros.diagnosis.evidence.spreads import Spreads, spreads
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.servos.nominal_servo import Servos
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.diagnosis.stages.stage import Stage
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects import effect
from trunk_ros.fleet.inputs.files import here
from trunk_ros.fleet.run.examine import Files, told, travel
from trunk_ros.fleet.run.outcome import Row
from trunk_ros.fleet.together.arm_effects import Followed, on_joints
from trunk_ros.model import Model
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.units import unit_on

ROUNDS = 2  # fits, each with the noise and the postures of the one before


def follow(path: str, model: Model, effects: Followed, servos: Servos | None = None) -> tuple[Row, Files]:
    """Values and spreads of given effects in a recording. ``servos``: the arm's.

    Raises OSError where the recording cannot be fetched.
    """
    with here(path) as local:
        return told(local, path, lambda: (_followed(local, model, effects, servos), {}))


def _followed(local: Path, model: Model, effects: Followed, servos: Servos | None) -> Row:
    recording = without_faults(read_recording(local))
    model = model.for_joints(recording.joints) if model.any_joints else model
    model = model if servos is None else servos.on(model)
    supposed = replace(model, effects={**model.effects, **on_joints(effects, model.arm.joints)})
    findings = [entry for stage in stages(recording, supposed) for entry in _fitted(stage, effects)]
    return {
        "reason": "",
        "time": recording.start_ns * 1e-9,
        "findings": findings,
        "errors": [],
        "travel": travel(recording, model),
    }


def stages(recording: Recording, model: Model) -> Iterator[Stage]:
    """The stages that a recording shows and the model has effects in."""
    needed = {effect(name).stage for name in model.effects}
    if "wire" in needed and {"gearbox_states", "joint_states"} <= set(recording.series):
        yield WireStage([wire_span(recording, model)], model, recording.units)
    if "servo" in needed and {"setpoints", "gearbox_states"} <= set(recording.series):
        yield ServoStage([servo_span(recording, model)], model, recording.units)


def _fitted(stage: Stage, effects: Followed) -> Iterator[dict[str, Any]]:
    context = first_look(stage)
    now = refit(context, context.known)
    for _ in range(ROUNDS):
        now = refit(context.seen_with(now.hypothesis).weighed(now.hypothesis), now.hypothesis)
    yield from _values(now, spreads(now), set(effects))


def _values(now: Fit, std: Spreads, wanted: set[str]) -> Iterator[dict[str, Any]]:
    stage = now.context.stage
    for (name, parameter, column), spread in std.items():
        if name not in wanted or not np.isfinite(spread):
            continue
        term, declared = now.hypothesis[name], effect(name).parameter(parameter)
        values = term.shared if column is None else term.own[column]
        joint = "arm" if column is None else stage.joints[column]
        unit = "rad" if column is None else stage.units.get(joint, "rad")
        yield {
            "stage": stage.name, "joint": joint, "effect": name, "parameter": parameter,
            "value": float(values[parameter]), "std": float(spread), "unit": unit_on(declared, unit),
            "confidence": 1.0, "word": None, "form": term.form, "equivalents": [],
        }  # fmt: skip
