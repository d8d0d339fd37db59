"""Whether the times of a table are in the unit that its mapping says."""

import numpy as np

from trunk_ros.recording.importing.mapping import Mapping
from trunk_ros.recording.recording import Floats, JointSeries

SLOW = 2.0  # s from row to row: nobody samples so rarely what moves smoothly,
FAST = 1e-4  # or an arm so often
_MANY, _SMOOTH = 300, 0.02  # rows; of the range from row to row: whoever stops to measure goes further
_RACES = 100.0  # rad/s: no joint does


def time_remarks(mapping: Mapping, series: dict[str, JointSeries]) -> list[str]:
    """A question where rows come so rarely, or joints so fast, that the unit of their times is doubtful.

    The pace is that of the topic with the most rows: those of others may lie anywhere between.
    """
    stamp = max((each.stamp for each in series.values()), key=len)
    if len(stamp) < 2:
        return []
    period = float(np.median(np.diff(stamp)))
    asked = "`rate_hz`" if mapping.time is None else "the unit of the time"
    told = f"a row every {period:.3g} s, {_spoken(float(stamp[-1]))} in all"
    if period >= SLOW and len(stamp) >= _MANY and all(_is_smooth(each.position) for each in series.values()):
        return [
            f"{told}, and all moves smoothly: is {asked} right? In ms it would be {_spoken(stamp[-1] / 1e3)}"
        ]
    if period <= FAST:
        return [f"{told}: is {asked} right?"]
    known = [each for key, each in series.items() if key == "joint_states"]
    speed = max((_speed(np.diff(each.stamp), each.position) for each in known), default=0.0)
    if speed > _RACES and "rad" in mapping.units().values():
        return [f"{told}, with joints at {speed:.3g} rad/s: is {asked} right, and that of the angles?"]
    return []


def _is_smooth(position: Floats) -> bool:
    """Whether every joint that moves takes small steps from row to row; of one without readings nothing is
    known.
    """
    position = position[:, np.isfinite(position).sum(axis=0) > 1]
    if not position.size:
        return True
    span = np.nanmax(position, axis=0) - np.nanmin(position, axis=0)
    steps = np.abs(np.diff(position, axis=0))
    told = np.isfinite(steps).any(axis=0)
    return bool(np.all(np.nanmean(steps[:, told], axis=0) <= _SMOOTH * span[told]))


def _speed(step: Floats, position: Floats) -> float:
    """rad/s that the fastest joint usually has while it moves; nothing of single jumps."""
    speeds = np.abs(np.diff(position, axis=0)) / step[:, None]
    return max((float(np.median(each[each > 0.0])) for each in speeds.T if (each > 0.0).any()), default=0.0)


def _spoken(seconds: float) -> str:
    return f"{seconds / 3600:.3g} h" if seconds > 7200 else f"{seconds:.3g} s"
