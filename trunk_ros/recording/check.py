"""What every recording must hold, however it was read."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from trunk_ros.errors import RecordingError
from trunk_ros.recording.recording import Floats, Recording
from trunk_ros.recording.topics import TIP, TOPICS

LARGEST = 1e12  # rad, m, N m: what is more was never measured, and its square is soon infinite


def is_reading(values: Floats) -> npt.NDArray[np.bool_]:
    """Whether values are finite, and not beyond anything that an arm could show."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(values) <= LARGEST)


def checked(recording: Recording) -> Recording:
    """RecordingError for a joint without a single finite value; empty velocity and effort become None."""
    series = {}
    for key, each in recording.series.items():
        blank = [not np.isfinite(column).any() for column in each.position.T]
        rest = [values for values in (each.velocity, each.effort) if values is not None]
        if any(blank) and not (key == "wire_states" and any(np.isfinite(values).any() for values in rest)):
            names = ", ".join(joint for joint, none in zip(each.joints, blank, strict=True) if none)
            raise RecordingError(f"{recording.name}: {TOPICS[key]} has no finite position of {names}")
        velocity, effort = (
            None if values is None or not np.isfinite(values).any() else values
            for values in (each.velocity, each.effort)
        )
        series[key] = replace(each, velocity=velocity, effort=effort)
    if recording.tip is not None and not np.isfinite(recording.tip.position).any():
        raise RecordingError(f"{recording.name}: {TOPICS[TIP]} has no finite position")
    if not series and recording.tip is None:
        raise RecordingError(f"{recording.name}: no sample in the part that was asked for")
    return replace(recording, series=series)
