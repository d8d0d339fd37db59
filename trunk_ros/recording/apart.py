"""Joints of one topic that were sampled at different times, as where each has a topic of its own."""

import numpy as np
import numpy.typing as npt

from trunk_ros.recording.block import Whole
from trunk_ros.recording.recording import JointSeries


def apart(series: JointSeries) -> list[JointSeries]:
    """The series in parts, one for the joints that were sampled together; mostly that is all of it."""
    known: npt.NDArray[np.bool_] = np.isfinite(series.position)
    for values in (series.velocity, series.effort):
        known |= False if values is None else np.isfinite(values)
    if known.all() or not known.any(axis=0).all():
        return [series]
    together = known.T.astype(np.float64) @ known > 0
    for _ in series.joints:  # a joint is also with those that its partners are with
        together = (together.astype(np.float64) @ together) > 0
    groups = np.unique(together, axis=0)[::-1]
    if len(groups) == 1:
        return [series]
    return [_rows(series, np.flatnonzero(group), known[:, group]) for group in groups]


def _rows(series: JointSeries, columns: Whole, known: npt.NDArray[np.bool_]) -> JointSeries:
    rows = np.flatnonzero(known.any(axis=1))
    part = series.select(tuple(series.joints[column] for column in columns))
    position, velocity, effort = (
        None if values is None else values[rows] for values in (part.position, part.velocity, part.effort)
    )
    assert position is not None
    return JointSeries(part.stamp[rows], part.joints, position, velocity, effort)
