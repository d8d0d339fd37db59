"""What is scored: a model run over a recording, or another simulator's recording of the same motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.chain import Chain
from trunk_ros.diagnosis.simulators.other_simulator import on_the_clock
from trunk_ros.diagnosis.tip.data import SIGNALS, UNITS, signals_of, tip_data
from trunk_ros.errors import RecordingError
from trunk_ros.evaluate.signals import Signal, of_joints, of_tip
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording
from trunk_ros.simulate import simulate


@dataclass(frozen=True)
class Prediction:
    """Signals of one recording as a model or a simulator has them, and as they were without it."""

    name: str
    before: list[Signal]
    after: list[Signal]


def of_model(recording: Recording, name: str, model: Model) -> Prediction:
    """A model's prediction; before: of its arm without effects. Raises RecordingError where the recording
    holds nothing to compare.
    """
    bare = replace(model, effects={})
    before, after = (_predicted(recording, one) for one in (bare, model))
    before += _tips(recording, model, bare)
    after += _tips(recording, model, model)
    if not after:
        raise RecordingError(
            f"{recording.name}: nothing to compare: it needs gearbox_states with setpoints or joint_states"
        )
    return Prediction(name, before, after)


def of_simulator(recording: Recording, name: str, simulator: Recording, first: Recording) -> Prediction:
    """Another simulator's recording of the same motion; before: that of the ``first`` one.

    Raises RecordingError where the two have no signal in common.
    """
    before, after = (_recorded(recording, on_the_clock(one, recording)) for one in (first, simulator))
    if not after:
        raise RecordingError(f"{name}: no joint of {recording.name} is in it: joints are matched by name")
    return Prediction(name, before, after)


def _predicted(recording: Recording, model: Model) -> list[Signal]:
    out, series = [], recording.series
    if {"setpoints", "gearbox_states"} <= set(series):
        said = simulate(recording, model, "setpoints").series["gearbox_states"]
        out += of_joints("servo", series["gearbox_states"], said, {})
    if "joint_states" in series:
        source = "gearbox_states" if "gearbox_states" in series else "setpoints"
        said = simulate(recording, model, source).series["joint_states"]
        out += of_joints("wire", series["joint_states"], said, recording.units)
    return out


def _recorded(recording: Recording, simulator: Recording) -> list[Signal]:
    out: list[Signal] = []
    for stage, key in (("servo", "gearbox_states"), ("wire", "joint_states")):
        if key in recording.series and key in simulator.series:
            units = recording.units if stage == "wire" else {}
            out += of_joints(stage, recording.series[key], simulator.series[key], units)
    if recording.tip is not None and simulator.tip is not None:
        out += of_tip(recording.tip, simulator.tip)
    return out


def _tips(recording: Recording, model: Model, judged: Model) -> list[Signal]:
    """The tip of the measured joint angles; the tip may have been recorded as late as the joints or not."""
    late = float(model.effects.get("sensor_delay", {}).get("delay", 0.0))
    found = (_tip(recording, model, judged, delay) for delay in sorted({0.0, late}))
    return min((signals for signals in found if signals), key=_power, default=[])


def _tip(recording: Recording, model: Model, judged: Model, delay: float) -> list[Signal]:
    data = tip_data(recording, model, delay)
    if data is None:
        return []
    error = data.off(Chain(judged, "arm").tip(data.theta, data.stamp))
    return [
        Signal(
            "arm",
            name,
            UNITS[name],
            data.stamp,
            data.seen[:, SIGNALS.index(name)],
            error[:, SIGNALS.index(name)],
        )
        for name in signals_of([data])
    ]


def _power(signals: list[Signal]) -> float:
    return float(sum(np.nanmean(signal.error**2) for signal in signals))
