"""Joints of one topic that were sampled at different times, as where each has a topic of its own."""

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from trunk_ros.recording.messages.block import Whole
from trunk_ros.recording.recording import Floats, JointSeries
from trunk_ros.recording.signal.through_readings import slopes

HELD = ("setpoints", "reference")  # what holds until the next sample
_GAP = 2.5  # periods; nothing is known of what lies in it


def apart(series: JointSeries) -> list[JointSeries]:
    """The series in parts, one for the joints that were sampled together; mostly that is all of it."""
    known: npt.NDArray[np.bool_] = np.isfinite(series.position)
    for values in (series.velocity, series.effort):
        known |= False if values is None else np.isfinite(values)
    if known.all() or not known.any(axis=0).all():
        return [series]
    counts = known.sum(axis=0)
    together = known.T.astype(np.float64) @ known > np.maximum.outer(counts, counts) / 2
    for _ in series.joints:  # a joint is also with those that its partners are with
        together = (together.astype(np.float64) @ together) > 0
    groups = np.unique(together, axis=0)[::-1]
    if len(groups) == 1:
        return [series]
    return [_rows(series, np.flatnonzero(group), known[:, group]) for group in groups]


def brought_together(series: JointSeries, held: bool, driving: bool = False) -> tuple[JointSeries, str]:
    """All joints at the stamps of those with the most samples, and what was done to the others, in words.

    Positions are interpolated by a cubic spline, of ``driving`` shafts by one that does not swing past the
    place where they stop, or held until the next sample; NaN within gaps.
    """
    parts = apart(series)
    if len(parts) == 1:
        return series, ""
    leading = max(parts, key=lambda part: len(part.stamp))
    stamp = leading.stamp
    columns = {joint: number for number, joint in enumerate(series.joints)}
    values = [np.full((len(stamp), len(columns)), np.nan) for _ in range(3)]
    for part in parts:
        for into, given in zip(values, (part.position, part.velocity, part.effort), strict=True):
            for number, joint in enumerate(part.joints if given is not None else ()):
                assert given is not None
                into[:, columns[joint]] = at_stamps(stamp, part.stamp, given[:, number], held, driving)
    others = ", ".join(joint for joint in series.joints if joint not in leading.joints)
    how = "held until their next sample" if held else "interpolated"
    said = f"joints were sampled at different times: {others} {how} to the stamps of {leading.joints[0]}"
    velocity, effort = (None if np.isnan(each).all() else each for each in values[1:])
    return JointSeries(stamp, series.joints, values[0], velocity, effort), said


def at_stamps(stamp: Floats, given_at: Floats, given: Floats, held: bool, driving: bool = False) -> Floats:
    """Values (n,) at other stamps (m,); NaN outside of the given ones, and within gaps."""
    known = np.isfinite(given)
    at, values = given_at[known], given[known]
    if len(at) < 2 or np.array_equal(stamp, given_at):
        return given if np.array_equal(stamp, given_at) else np.full(len(stamp), np.nan)
    before = np.clip(np.searchsorted(at, stamp, side="right") - 1, 0, len(at) - 2)
    found: Floats
    if held:
        found = values[before + (stamp >= at[-1])]
    elif driving:
        found = CubicHermiteSpline(at, values, slopes(at, values, None))(stamp)
    else:  # noise of a joint's readings stays what it is
        found = CubicSpline(at, values)(stamp)
    outside = (stamp < at[0]) | ((stamp > at[-1]) & (not held))
    far = np.diff(at)[before] > _GAP * np.median(np.diff(at))
    exact = np.isin(stamp, at)
    return np.where((outside | (far & (not held))) & ~exact, np.nan, found)


def _rows(series: JointSeries, columns: Whole, known: npt.NDArray[np.bool_]) -> JointSeries:
    rows = np.flatnonzero(known.any(axis=1))
    part = series.select(tuple(series.joints[column] for column in columns))
    position, velocity, effort = (
        None if values is None else values[rows] for values in (part.position, part.velocity, part.effort)
    )
    assert position is not None
    return JointSeries(part.stamp[rows], part.joints, position, velocity, effort)
