"""Where a recording is two: the clock was set while it was made, or it stood still for longer than it ran."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from trunk_ros.recording.messages.block import Whole

HOLE = 600.0  # s without any sample that are a hole, whatever the rate
SLOW = 100  # usual times between samples that are none
FEWEST = 100  # samples of a part that is worth reading
SECOND = 10**9


def parts(topics: Sequence[Whole]) -> list[tuple[int, int]]:
    """[first, end) ns of the parts, one after the other, of a recording whose topics have stamps (n,) ns.

    It is cut in holes that are longer than all that was recorded, where a topic goes on behind them.
    """
    stamp = np.unique(np.concatenate(topics))
    step = np.diff(stamp)
    if not len(step):
        return [(int(stamp[0]), int(stamp[-1]) + 1)]
    hole = step > max(HOLE * SECOND, SLOW * float(np.median(step)))
    cuts = np.flatnonzero(hole & (step > step[~hole].sum()))
    begins = [int(stamp[k + 1]) for k in cuts if any(_goes_on(each, stamp[k]) for each in topics)]
    edges = [int(stamp[0]), *begins, int(stamp[-1]) + 1]
    return list(pairwise(edges))


def _goes_on(stamp: Whole, last: np.int64) -> bool:
    return bool((stamp <= last).any() and (stamp > last).any())


def samples(topics: Sequence[Whole], part: tuple[int, int]) -> int:
    """How many samples of the topics are in a part."""
    return sum(int(((each >= part[0]) & (each < part[1])).sum()) for each in topics)


def remark(topics: Sequence[Whole], here: tuple[int, int], other: tuple[int, int], read: bool) -> str:
    """What is said in one part of another one. read: whether that is read as well."""
    off = other[0] - here[0]
    when = f"{duration(abs(off) / SECOND)} {'later' if off > 0 else 'earlier'}"
    count = samples(topics, other)
    what = "a recording of its own" if read else "left out"
    are = f"{count} message{'' if count == 1 else 's'}"
    return f"the clock was set, or the arm not recorded for long: {are} stamped {when}, {what}"


def duration(seconds: float) -> str:
    """A time in the unit in which it is read easily."""
    for unit, size in (("years", 365.25 * 86400), ("days", 86400.0), ("hours", 3600.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.4g} s"
