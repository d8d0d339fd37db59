"""A table that others recorded, as a recording of an arm, by a mapping."""

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

ALIKE = 0.5  # of the rows that are of all topics: of a table whose topics have the same times
_LATEST_NS = (2**31) * 10**9


def read_csv(path: str | Path, mapping: Mapping | str | Path) -> Recording:
    """The table at `path` as a recording in SI units. mapping: a file, a name in config/import, or loaded.

    Of rows with the same stamp the first counts. Where most rows are of some topics only, a topic has a
    message for each row that is of it. RecordingError in one line.
    """
    path = Path(path)
    mapping = mapping if isinstance(mapping, Mapping) else load_mapping(mapping)
    if mapping.of_bag:
        raise RecordingError(f"{path}: is a table: give `time: {{column: …, unit: s}}` or `rate_hz`")
    table, remarks = read_table(path, mapping.columns, mapping.delimiter)
    stamp_ns, rows, timing = _times(path, mapping, table)
    start_ns = int(stamp_ns[0])
    stamp = (stamp_ns - start_ns) / 1e9
    series = {
        key: _series(stamp, mapping.joints, {n: _values(q, table)[rows] for n, q in topic.items()})
        for key, topic in mapping.topics.items()
    }
    series, sparse = _of_their_rows(series)
    full = {key: Counts(len(each.stamp), not_finite=_not_finite(each)) for key, each in series.items()}
    notes = tuple(
        remarks + timing + sparse + time_remarks(mapping, stamp, series) + series_remarks(series, full)
    )
    units = {joint: unit for joint, unit in mapping.units().items() if unit != "rad"}
    whole = Recording(str(path), start_ns, float(stamp[-1]), series, None, notes, units, counts=full)
    return whole.checked()


def _times(path: Path, mapping: Mapping, table: dict[str, Floats]) -> tuple[Whole, Whole, list[str]]:
    """Stamps in ns (rising, unique), the rows that they belong to, and remarks."""
    count = len(next(iter(table.values())))
    if mapping.time is None:
        seconds = np.arange(count) / mapping.rate_hz
    else:
        with np.errstate(over="ignore"):
            seconds = mapping.time[0].evaluate(table) * mapping.time[1]
    known = np.flatnonzero(np.isfinite(seconds))
    if not len(known):
        raise RecordingError(f"{path}: the time has no finite value")
    remarks = [f"{count - len(known)} rows have no time and are left out"] if len(known) < count else []
    seconds = seconds[known]
    if seconds.min() <= -_LATEST_NS / 1e9:
        raise RecordingError(f"{path}: the time begins at {seconds.min():.3g} s: is its unit right?")
    if seconds.min() < 0:
        remarks.append(f"time begins at {seconds.min():g} s: moved to begin at 0")
        seconds = seconds - seconds.min()
    if not seconds.max() < _LATEST_NS / 1e9:
        raise RecordingError(f"{path}: the time reaches {seconds.max():.3g} s: is its unit right?")
    every = np.rint(seconds * 1e9).astype(np.int64)
    stamp_ns, first = np.unique(every, return_index=True)
    if len(every) > len(stamp_ns):
        remarks.append(f"{len(every) - len(stamp_ns)} rows repeated a stamp: the first of each counts")
    if disorder := int((np.diff(every) < 0).sum()):
        remarks.append(f"{disorder} rows out of order, sorted by stamp")
    return stamp_ns, known[first], remarks


def _values(quantity: Quantity, table: dict[str, Floats]) -> Floats:
    """(rows, joints) in SI."""
    values = np.column_stack([each.evaluate(table) for each in quantity.columns])
    with np.errstate(over="ignore"):
        scaled: Floats = values * np.array([UNITS[unit][1] for unit in quantity.units])
    return np.where(is_reading(scaled), scaled, np.nan)


def _series(stamp: Floats, joints: tuple[str, ...], values: dict[str, Floats]) -> JointSeries:
    return JointSeries(stamp, joints, values["position"], values.get("velocity"), values.get("effort"))


def _of_their_rows(series: dict[str, JointSeries]) -> tuple[dict[str, JointSeries], list[str]]:
    """Topics that were written as they came, each with its own rows; else an empty field is a reading
    that was lost.
    """
    says = {key: _says(each) for key, each in series.items()}
    topics = np.sum(list(says.values()), axis=0)
    whole, some = int(np.sum(topics == len(says))), int(np.sum(topics > 0))
    if whole > ALIKE * some or not all(each.any() for each in says.values()):
        return series, []
    told = ", ".join(f"{key} in {int(each.sum())}" for key, each in says.items())
    return {key: each.rows(says[key]) for key, each in series.items()}, [f"rows of single topics: {told}"]


def _says(series: JointSeries) -> np.ndarray:
    """(rows,) whether any field of a topic is filled."""
    return np.asarray(np.isfinite(np.hstack(_measured(series))).any(axis=1))


def _not_finite(series: JointSeries) -> int:
    return sum(int(np.isnan(each).sum()) for each in _measured(series))


def _measured(series: JointSeries) -> list[Floats]:
    return [each for each in (series.position, series.velocity, series.effort) if each is not None]
