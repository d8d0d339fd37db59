"""A table that others recorded, as a recording of an arm, by a mapping."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from trunk_ros.errors import RecordingError
from trunk_ros.recording.check import is_reading
from trunk_ros.recording.importing.mapping import Mapping, Quantity, load_mapping
from trunk_ros.recording.importing.pace import time_remarks
from trunk_ros.recording.importing.table import read_table
from trunk_ros.recording.importing.units import UNITS
from trunk_ros.recording.messages.block import Whole
from trunk_ros.recording.recording import Counts, Floats, JointSeries, Recording
from trunk_ros.recording.remarks import series_remarks
from trunk_ros.recording.restarts import began_anew
from trunk_ros.recording.signal.gaps import GAP
from trunk_ros.recording.topics import TOPICS
from trunk_ros.words import many

_LATEST_NS = (2**31) * 10**9


def read_csv(path: str | Path, mapping: Mapping | str | Path) -> Recording:
    """The table at `path` as a recording in SI units. mapping: a file, a name in config/import, or loaded.

    A row without a value of a topic is no message of it; of the others with the same stamp the first counts.
    Rows out of order are sorted; several runs in one table, whose time begins anew, are a RecordingError, in
    one line as all are.
    """
    path = Path(path)
    mapping = mapping if isinstance(mapping, Mapping) else load_mapping(mapping)
    if mapping.of_bag:
        raise RecordingError(f"{path}: is a table: give `time: {{column: …, unit: s}}` or `rate_hz`")
    dates = mapping.time_columns if mapping.dates else ()
    table, remarks = read_table(path, mapping.columns, mapping.delimiter, mapping.decimal, dates)
    every_ns, rows, timing = _times(path, mapping, table)
    values = {
        key: {name: _values(each, table)[rows] for name, each in topic.items()}
        for key, topic in mapping.topics.items()
    }
    told = {key: _told(list(each.values())) for key, each in values.items()}
    for each in told.values():
        if anew := began_anew(every_ns[each], _named(rows[each])):
            raise RecordingError(
                f"{path}: {anew}. Cut the table there, one run per file (row 1 follows the header)"
            )
    kept = {key: each[np.unique(every_ns[each], return_index=True)[1]] for key, each in told.items()}
    start_ns = min(int(every_ns[each[0]]) for each in kept.values())
    series = {
        key: _series((every_ns[each] - start_ns) / 1e9, mapping.joints, values[key], each)
        for key, each in kept.items()
    }
    full = {key: Counts(len(each.stamp), not_finite=_not_finite(each)) for key, each in series.items()}
    timing += _left_out(every_ns, told, kept)
    notes = tuple(remarks + timing + time_remarks(mapping, series) + series_remarks(series, full))
    units = {joint: unit for joint, unit in mapping.units().items() if unit != "rad"}
    duration = max(float(each.stamp[-1]) for each in series.values())
    return Recording(str(path), start_ns, duration, series, None, notes, units, counts=full).checked()


def _times(path: Path, mapping: Mapping, table: dict[str, Floats]) -> tuple[Whole, Whole, list[str]]:
    """Stamps in ns, the rows that they belong to, and remarks."""
    count = len(next(iter(table.values())))
    if mapping.time is None:
        seconds = np.arange(count) / mapping.rate_hz
    else:
        with np.errstate(over="ignore"):
            seconds = mapping.time[0].evaluate(table) * mapping.time[1]
    known = np.flatnonzero(np.isfinite(seconds))
    if not len(known):
        raise RecordingError(f"{path}: the time has no finite value")
    remarks = [f"{many(count - len(known), 'row')} without a time left out"] if len(known) < count else []
    seconds = seconds[known]
    if len(seconds) > 1 and seconds.min() == seconds.max():
        raise RecordingError(
            f"{path}: the time is {seconds[0]:g} s in all {len(seconds)} rows: is it the right column? "
            "Where a table has no time, give `rate_hz`"
        )
    if seconds.min() <= -_LATEST_NS / 1e9:
        raise RecordingError(f"{path}: the time begins at {seconds.min():.3g} s: is its unit right?")
    if seconds.min() < 0:
        remarks.append(f"time begins at {seconds.min():g} s: moved to begin at 0")
        seconds = seconds - seconds.min()
    if not seconds.max() < _LATEST_NS / 1e9:
        raise RecordingError(f"{path}: the time reaches {seconds.max():.3g} s: is its unit right?")
    every = np.rint(seconds * 1e9).astype(np.int64)
    if disorder := int((np.diff(every) < 0).sum()):
        remarks.append(f"{many(disorder, 'row')} out of order, sorted by stamp")
    return every, known, remarks


def _named(rows: Whole) -> Callable[[int], str]:
    return lambda k: f"row {rows[k] + 1}"


def _told(values: list[Floats]) -> Whole:
    """The rows that have a value of a topic; all where none has, so that its joints can be named."""
    rows = np.flatnonzero(np.isfinite(np.column_stack(values)).any(axis=1))
    return rows if len(rows) else np.arange(len(values[0]))


def _blank(every_ns: Whole, told: Whole) -> int:
    """Rows in which a topic says nothing though it was due, by its own pace: other topics have rows between
    its own. A pace that falls between those rows takes now one more of them, now one less.
    """
    seen = np.sort(every_ns[told])
    steps = np.diff(seen)
    steps = steps[steps > 0]
    if len(told) == len(every_ns) or not len(steps):
        return len(every_ns) - len(told)
    usual = float(np.median(steps))
    pace = float(np.mean(steps[steps <= 2 * usual]))
    late = np.diff(seen) > GAP * pace
    least = usual if late.any() else pace
    rest = np.sort(np.delete(every_ns, told))
    after = np.searchsorted(seen, rest, side="right")
    due = np.concatenate([[seen[0] - rest[0] >= least], late, [rest[-1] - seen[-1] >= least]])
    return int(np.count_nonzero(due[after] & ~np.isin(rest, seen)))


def _left_out(every_ns: Whole, told: dict[str, Whole], kept: dict[str, Whole]) -> list[str]:
    """What is said of rows that are no messages of a topic: those that were not ``told``, and repeated
    stamps, of which one was ``kept``.
    """
    said: dict[str, list[str]] = {}
    for key, each in told.items():
        if blank := _blank(every_ns, each):
            said.setdefault(f"{many(blank, 'row')} without a value left out", []).append(TOPICS[key])
        if repeated := len(each) - len(kept[key]):
            text = f"{many(repeated, 'row')} repeated a stamp: the first of each counts"
            said.setdefault(text, []).append(TOPICS[key])
    return [
        text if len(topics) == len(told) and "repeated" in text else f"{', '.join(topics)}: {text}"
        for text, topics in said.items()
    ]


def _values(quantity: Quantity, table: dict[str, Floats]) -> Floats:
    """(rows, joints) in SI."""
    values = np.column_stack([each.evaluate(table) for each in quantity.columns])
    with np.errstate(over="ignore"):
        scaled: Floats = values * np.array([UNITS[unit][1] for unit in quantity.units])
    return np.where(is_reading(scaled), scaled, np.nan)


def _series(stamp: Floats, joints: tuple[str, ...], values: dict[str, Floats], rows: Whole) -> JointSeries:
    taken = {name: each[rows] for name, each in values.items()}
    return JointSeries(stamp, joints, taken["position"], taken.get("velocity"), taken.get("effort"))


def _not_finite(series: JointSeries) -> int:
    values = [each for each in (series.position, series.velocity, series.effort) if each is not None]
    return sum(int(np.isnan(each).sum()) for each in values)
