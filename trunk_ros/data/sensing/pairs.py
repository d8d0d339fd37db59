"""Topics of a recording side by side, and a recording in which one of them was looked at."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from trunk_ros.arm_model import ArmModel
from trunk_ros.data.align import common_joints
from trunk_ros.effects import imitated
from trunk_ros.errors import RecordingError
from trunk_ros.recording.observed import Observed
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.words import listed


def pair(
    recording: Recording, model: ArmModel, first: str, second: str
) -> tuple[JointSeries, JointSeries] | None:
    """Two topics with the joints that both and the model have, and of which readings are left; None where
    there is no such pair.
    """
    if not {first, second} <= set(recording.series):
        return None
    a, b = recording.series[first], recording.series[second]
    try:
        joints = common_joints(recording, model, a, b)
    except RecordingError:  # is said where it matters
        return None
    read = tuple(
        joint for joint in joints if all(np.isfinite(s.select((joint,)).position).any() for s in (a, b))
    )
    return (a.select(read), b.select(read)) if read else None


def seen(recording: Recording, observed: Observed, **series: JointSeries) -> Recording:
    """The recording with what was observed, and the topics that were put right."""
    return replace(recording, series={**recording.series, **series}, observed=(*recording.observed, observed))


def told(
    kind: str, where: tuple[str, tuple[str, ...]], value: float, std: float | None, unit: str, said: str,
    advice: str = "", corrected: bool = True, stages: Collection[str] = (),
) -> Observed:  # fmt: skip
    """What was observed on a topic and some of its joints (``where``), with what it looks like, in some
    ``stages`` if it is not seen in others.
    """
    looks = imitated(kind, stages)
    would = "It would have looked like" if corrected else "It may look like"
    statement = ". ".join(filter(None, (said, f"{would} {listed(looks, 'or')}", advice)))
    return Observed(kind, *where, value, std, unit, corrected, looks, statement)
