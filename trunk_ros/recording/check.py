"""What every recording must hold, however it was read."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from trunk_ros.errors import RecordingError
from trunk_ros.recording.series import Floats, JointSeries, PoseSeries
from trunk_ros.recording.topics import TIP, TOPICS

LARGEST = 1e12  # rad, m, N m: what is more was never measured, and its square is soon infinite


def is_reading(values: Floats) -> npt.NDArray[np.bool_]:
    """Whether values are finite, and not beyond anything that an arm could show."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(values) <= LARGEST)


def checked(name: str, series: dict[str, JointSeries], tip: PoseSeries | None) -> dict[str, JointSeries]:
    """The series of the recording ``name``, empty velocity and effort as None; RecordingError for a joint
    without a single finite value.
    """
    kept = {}
    for key, each in series.items():
        blank = [not np.isfinite(column).any() for column in each.position.T]
        rest = [values for values in (each.velocity, each.effort) if values is not None]
        if any(blank) and not (key == "wire_states" and any(np.isfinite(values).any() for values in rest)):
            names = ", ".join(joint for joint, none in zip(each.joints, blank, strict=True) if none)
            raise RecordingError(f"{name}: {TOPICS[key]} has no finite position of {names}")
        velocity, effort = (
            None if values is None or not np.isfinite(values).any() else values
            for values in (each.velocity, each.effort)
        )
        kept[key] = replace(each, velocity=velocity, effort=effort)
    if tip is not None and not np.isfinite(tip.position).any():
        raise RecordingError(f"{name}: {TOPICS[TIP]} has no finite position")
    if not series and tip is None:
        raise RecordingError(f"{name}: no sample in the part that was asked for")
    return kept
