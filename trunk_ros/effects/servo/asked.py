"""What the position loop of a servo asks for in a step: of which setpoints, and how fast."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled

EDGE = 0.01  # of a dead zone, over which the loop's answer rises: with a jump no two runs would agree


@compiled
def beyond(error: float, zone: float) -> float:
    """What a loop answers to of an error; clear of the zone's edge without the divisions, for which each step
    would wait.
    """
    size = abs(error)
    if size >= zone * (1.0 + EDGE):
        return error
    if size <= zone * (1.0 - EDGE):
        return 0.0 * error
    return error * min(max((size / zone - 1.0) / EDGE + 0.5, 0.0), 1.0)


@compiled
def speed_asked(
    setpoint: Array,
    stamp: Array,
    j: int,
    held: int,
    t: float,
    h: float,
    gain: float,
    rest: float,
    zone: float,
    least: float,
    most: float,
) -> float:
    """rad/s in a step of ``h`` s from ``t`` on in which setpoints change, from row ``held`` on: the mean of
    what each asks for, between ``least`` and ``most``. What the mean of them would ask for is the top speed
    for all of a step of which the new one has a part; ``rest`` is what else is in the error.
    """
    before = min(max(gain * beyond(setpoint[held, j] + rest, zone), least), most)
    mean, after = before, held + 1
    while after < len(stamp) and stamp[after] < t + h - 1e-9:
        now = min(max(gain * beyond(setpoint[after, j] + rest, zone), least), most)
        mean += (t + h - stamp[after]) / h * (now - before)
        before = now
        after += 1
    return mean


@compiled
def mean_of(values: Array, stamp: Array, j: int, held: int, t: float, h: float) -> float:
    """The mean in a step of ``h`` s from ``t`` on of what changes with setpoints, from row ``held`` on."""
    mean, after = values[held, j], held + 1
    while after < len(stamp) and stamp[after] < t + h - 1e-9:
        mean += (t + h - stamp[after]) / h * (values[after, j] - values[after - 1, j])
        after += 1
    return float(mean)


@compiled
def ask(
    setpoint: Array,
    stamp: Array,
    begun: float,
    delay: Array,
    h: Array,
    substeps: np.ndarray,
    clocked: np.ndarray,
    held: np.ndarray,
    first: int,
    last: int,
    asked: Array,
    first_of: np.ndarray,
    mixed: np.ndarray,
) -> None:
    """What the loops of each column are asked for (last - first, columns) at some of the steps from ``begun``
    s on, mean over each; ``held`` (columns,): the setpoints that act. ``mixed`` (last - first,) tells of a
    step whether setpoints change in it, ``first_of`` (likewise, columns) from which one on, -1: they do not.
    """
    columns = len(h)
    mixed[: last - first] = False
    first_of[: last - first] = -1
    j = 0
    while j < columns:
        end = j + 1
        while end < columns and clocked[end]:
            end += 1
        now = held[j]
        for i in range(first, min(last, substeps[j])):
            t = begun + i * h[j] - delay[j]
            while now + 1 < len(stamp) and stamp[now + 1] <= t + 1e-9:
                now += 1
            for m in range(j, end):
                asked[i - first, m] = setpoint[now, m]
            after = now + 1
            while after < len(stamp) and stamp[after] < t + h[j] - 1e-9:
                share = (t + h[j] - stamp[after]) / h[j]
                for m in range(j, end):
                    asked[i - first, m] += share * (setpoint[after, m] - setpoint[after - 1, m])
                    if setpoint[after, m] != setpoint[after - 1, m]:
                        mixed[i - first], first_of[i - first, m] = True, now
                after += 1
        held[j] = now
        j = end
