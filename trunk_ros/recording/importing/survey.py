"""What a table holds, and which of its columns is its time, before anybody has said what is what."""

import csv
import re
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from trunk_ros.errors import RecordingError
from trunk_ros.recording.importing.field import are_numbers, as_number, is_date, with_comma
from trunk_ros.recording.importing.pace import FAST, SLOW
from trunk_ros.recording.importing.rows import opened, refuse_binary
from trunk_ros.recording.importing.units import DATES, TIME_UNITS

_SOME, _MANY = 20, 10_000  # rows in which a decimal comma shows, and the course of a time
_BACK, _ON = 0.01, 0.5  # shares of the rows in which a time may fall back, and has to go on
_LATEST = 4e9  # s since 1970, or whenever a clock began
_TIMES = re.compile(r"t|.*(time|stamp|sec).*|t[^a-z].*", re.IGNORECASE)


@dataclass(frozen=True)
class Survey:
    """names: of the columns, with the `first` value of each; count: of rows; decimal: "." or ",".

    time: the column of times, "" where there is none, and its `unit`.
    """

    names: list[str]
    first: list[str]
    count: int
    delimiter: str
    decimal: str
    time: str
    unit: str


def survey(path: Path) -> Survey:
    """The table at `path`. RecordingError in one line where it is none."""
    try:
        refuse_binary(path)
        with path.open(encoding="utf-8-sig", newline="") as stream:
            table = opened(stream)
            _check(path, table.names, table.line)
            rows = list(islice((row for row in table.rows if row), _MANY))
            count = len(rows) + sum(1 for row in table.rows if row)
    except (OSError, ValueError, csv.Error) as error:
        raise RecordingError(f"{path}: cannot be read as a table ({error})") from None
    commas = table.delimiter != "," and any(with_comma(field) for row in rows[:_SOME] for field in row)
    columns = [[row[k].strip() if k < len(row) else "" for row in rows] for k in range(len(table.names))]
    first = [column[0] if column else "" for column in columns]
    rising = [k for k, column in enumerate(columns) if _rises(column)]
    times = [k for k in rising if _TIMES.fullmatch(table.names[k].lstrip("#%"))] or rising
    time = table.names[times[0]] if times else ""
    unit = _unit_of(time, columns[times[0]]) if times else ""
    return Survey(table.names, first, count, table.delimiter, "," if commas else ".", time, unit)


def _check(path: Path, names: list[str], line: int) -> None:
    if not any(names):
        raise RecordingError(f"{path}: is empty: a table begins with the names of its columns")
    if are_numbers(names):
        raise RecordingError(
            f"{path}: line {line} holds numbers: a table begins with the names of its columns"
        )


def _values(column: list[str]) -> np.ndarray:
    """(n,) numbers of a column; NaN where it has none."""
    known = [as_number(field) for field in column]
    return np.array([np.nan if value is None else value for value in known])


def _rises(column: list[str]) -> bool:
    """Whether a column increases throughout, as a time does: rows may come late, and stamps repeat."""
    values = _values(column)
    steps = np.diff(values[np.isfinite(values)])
    if not len(steps):
        return True
    return bool(np.mean(steps < 0.0) <= _BACK and np.mean(steps > 0.0) >= _ON)


def _unit_of(name: str, column: list[str]) -> str:
    """The unit of a column of times: by its first value, which may be a date, by what its name ends with,
    such as "t_ms" and "time[ns]", or by its size where it cannot be s; else s.
    """
    if column and is_date(column[0]):
        return DATES
    last = re.split(r"[^a-z]+", name.lower().rstrip(")] "))[-1]
    if last in TIME_UNITS:
        return last
    values = _values(column)
    if len(values) < 2 or not values[0] > _LATEST:
        return "s"
    step = float(np.median(np.diff(values)))
    fits = [u for u, f in TIME_UNITS.items() if values[0] * f < _LATEST and FAST < step * f < SLOW]
    return fits[0] if fits else "s"
