"""Several readings at each rest of an arm that stops to measure: one of each rest."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.motion_content import STANDS
from trunk_ros.levels import SEVERAL, SLIGHT
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.signal.resample import SLOW, stops_to_measure

WIRES = ("gearbox_states", "joint_states")


def one_of_each_rest(recording: Recording) -> Recording:
    """A recording whose motors and joints were read in bursts, while the motors rested, with the medians of
    each: what was read at one rest is one place. Where motors have moved by the last reading, a mean would
    have gone with them. Any other as it is.
    """
    if any(key not in recording.series for key in WIRES):
        return recording
    found = {key: rests for key, each in recording.series.items() if (rests := _rests(each)) is not None}
    if any(key not in found for key in WIRES) or not _stand(recording.series["gearbox_states"]):
        return recording
    if "setpoints" in found and not _stand(recording.series["setpoints"]):
        del found["setpoints"]
    joints = found["joint_states"].stamp
    several = len(recording.series["joint_states"].stamp) / len(joints)
    note = (
        f"read at {len(joints)} rests, {several:.3g} times at each: the medians of each count, nothing is "
        "missing between them"
    )
    return replace(recording, series=recording.series | found, notes=(*recording.notes, note))


def of_few_rests(recording: Recording, least: int) -> str:
    """What is said of an arm that stops to measure less than so often; "" of any other."""
    shown = recording.series.get("joint_states")
    if shown is None or len(shown.stamp) >= least or not stops_to_measure(shown.stamp):
        return ""
    return (
        f"joints were read at {len(shown.stamp)} rests, each of which counts once: stop {least} times or more"
    )


def _rests(series: JointSeries) -> JointSeries | None:
    """The medians of each burst of readings; None where they do not come in bursts that are apart in time."""
    bursts = _bursts(series.stamp)
    if len(bursts) <= SEVERAL or stops_to_measure(series.stamp):
        return None
    effort = None if series.effort is None else _medians(series.effort, bursts)
    stamp = _medians(series.stamp[:, None], bursts)[:, 0]
    return JointSeries(stamp, series.joints, _medians(series.position, bursts), None, effort)


def _stand(series: JointSeries) -> bool:
    """Whether what moves does so between bursts: halves of each differ by little of what these do."""
    bursts = _bursts(series.stamp)
    at = _medians(series.position, bursts)
    between = np.nansum(np.abs(np.diff(at, axis=0)), axis=0)
    early = _medians(series.position, [(first, (first + last + 1) // 2) for first, last in bursts])
    late = _medians(series.position, [((first + last) // 2, last) for first, last in bursts])
    within, moves = np.nansum(np.abs(late - early), axis=0), between > STANDS * len(bursts)
    return bool(moves.any() and np.all(within[moves] < SLIGHT * between[moves]))


def _bursts(stamp: Array) -> list[tuple[int, int]]:
    """The first row of each burst, and the one after its last."""
    first = np.flatnonzero(np.concatenate([[True], np.diff(stamp) > SLOW])).tolist()
    return list(pairwise([*first, len(stamp)]))


def _medians(values: Array, bursts: list[tuple[int, int]]) -> Array:
    """(bursts, columns) of what is known of each."""
    out = np.full((len(bursts), values.shape[1]), np.nan)
    for k, (first, last) in enumerate(bursts):
        for j, column in enumerate(values[first:last].T):
            if (known := column[np.isfinite(column)]).size:
                out[k, j] = np.median(known)
    return out
