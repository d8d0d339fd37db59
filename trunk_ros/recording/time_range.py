"""The part of a recording that `--from-time` and `--until` ask for."""

import math
from dataclasses import replace

from trunk_ros.errors import ArgumentError
from trunk_ros.recording.recording import Recording


def time_range(duration: float, from_time: str | None, until: str | None) -> tuple[float, float]:
    """(first, end) s since the start: what is kept is first <= stamp < end. Given in s or "%".

    What reaches the end of the recording includes its last sample. ArgumentError names what cannot be used.
    """
    first = 0.0 if from_time is None else _seconds("--from-time", from_time, duration)
    end = math.inf if until is None else _seconds("--until", until, duration)
    end = math.inf if end >= duration else end
    if first > duration:
        raise ArgumentError(f"--from-time {from_time}: the recording ends at {duration:g} s")
    if first >= end:
        raise ArgumentError(f"--from-time {from_time} is not before --until {until}")
    return first, end


def part_of(recording: Recording, from_time: str | None, until: str | None) -> Recording:
    """The part that is asked for, with a note where the recording ends before that."""
    part = recording.part(*time_range(recording.duration, from_time, until))
    if until is None or _seconds("--until", until, recording.duration) <= recording.duration:
        return part
    note = f"--until {until} is beyond the end of the recording, which is at {recording.duration:.4g} s"
    return replace(part, notes=(*part.notes, note))


def _seconds(option: str, value: str, duration: float) -> float:
    text = str(value).strip()
    share = text.endswith("%")
    try:
        number = float(text.rstrip("% ") if share else text.removesuffix("s"))
    except ValueError:
        number = math.nan
    if not math.isfinite(number) or number < 0 or (share and number > 100):
        raise ArgumentError(f"{option} {text!r}: give seconds like 12.5, or a share like 70%")
    return number / 100 * duration if share else number
