"""Another simulator's recording in the place of the model's prediction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.data.align import Span, in_gaps
from trunk_ros.diagnosis.wire import WireStage
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording


def on_the_clock(other: Recording, recording: Recording) -> Recording:
    """Another recording of a motion with its stamps counted from the start of ``recording``.

    Where their stamps are not of the same time, both starts are taken as one moment.
    """
    off = (other.start_ns - recording.start_ns) / 1e9
    if not off or abs(off) >= recording.duration:
        return other
    series = {key: replace(each, stamp=each.stamp + off) for key, each in other.series.items()}
    return replace(other, start_ns=recording.start_ns, series=series)


def shifted(span: Span, model: Model, against: Recording) -> Span:
    """Targets as if the model's own prediction were the other simulator's: its difference is taken off."""
    said = against.require("joint_states").select(span.joints)
    span = replace(span, start=(np.empty(0, dtype=int),) * len(span.joints))
    context = Context.of(WireStage([span], model))
    target, valid = span.target.copy(), span.valid.copy()
    inside = (span.stamp >= said.stamp[0]) & (span.stamp <= said.stamp[-1])
    lost = in_gaps(said, span.stamp)
    for c in range(len(span.joints)):
        known = np.isfinite(said.position[:, c])
        there = np.interp(span.stamp, said.stamp[known], said.position[known, c])
        target[:, c] += context.predict(0, context.known, c) - there
        valid[:, c] &= inside & ~lost[:, c]
    return replace(span, target=target, valid=valid)


def completed(recording: Recording, other: Recording | None) -> Recording:
    """A recording without gearbox angles takes them from the other simulator's."""
    if other is None or "gearbox_states" in recording.series or "gearbox_states" not in other.series:
        return recording
    note = f"gearbox angles were not recorded: those of {other.name} are used"
    gearbox = on_the_clock(other, recording).series["gearbox_states"]
    series = {**recording.series, "gearbox_states": gearbox}
    return replace(recording, series=series, notes=(*recording.notes, note))
