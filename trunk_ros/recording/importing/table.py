"""The columns of a CSV file that are needed, as arrays."""

import csv
import json
from array import array
from collections.abc import Callable, Collection
from pathlib import Path

import numpy as np

from trunk_ros.errors import RecordingError
from trunk_ros.recording.importing.field import are_numbers, as_date, is_date, with_comma
from trunk_ros.recording.importing.rows import Rows, opened, refuse_binary
from trunk_ros.recording.importing.units import DATES
from trunk_ros.recording.recording import Floats

_EMPTY = {"", "nan", "na", "n/a", "null", "none", "-"}


def read_table(
    path: Path, columns: tuple[str, ...], delimiter: str, decimal: str = ".", dates: Collection[str] = ()
) -> tuple[dict[str, Floats], list[str]]:
    """({column: (rows,)}, remarks): NaN where a field is empty; s since 1970 in columns that hold ``dates``.
    A last line that is cut is left out and said.

    RecordingError names a column that is missing and those that are there, or the line that cannot be read,
    or says that there is no header.
    """
    try:
        refuse_binary(path)
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
            table = opened(stream, delimiter)
            _check(path, table, columns)
            places = [table.names.index(name) for name in columns]
            read = [as_date if name in dates else _number(decimal) for name in columns]
            values, remarks = _values(path, table, list(zip(places, read, strict=True)))
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from None
    except csv.Error as error:
        raise RecordingError(f"{path}: is not CSV ({error})") from None
    if not len(values[0]):
        raise RecordingError(f"{path}: has a header and no rows")
    return dict(zip(columns, values, strict=True)), remarks


def _check(path: Path, table: Rows, columns: tuple[str, ...]) -> None:
    header, numbers = table.names, ", ".join(table.names)[:60]
    missing = [name for name in columns if name not in header]
    if not any(header):
        raise RecordingError(f"{path}: is empty: a table begins with the names of its columns")
    other = _otherwise(path) if missing and len(header) == 1 else table
    if are_numbers(other.names):
        raise RecordingError(
            f"{path}: line {table.line} holds numbers ({numbers}): "
            "put a line with the names of the columns above it"
        )
    if missing:
        there, hint = ", ".join(header), ""
        if len(other.names) > len(header):
            there = other.delimiter.join(other.names)
            hint = f" in one: the mapping wants `delimiter: {json.dumps(other.delimiter)}`"
        there = there[:600] or "none"
        raise RecordingError(f"{path}: has no column {', '.join(missing)}; there are {there}{hint}")
    if double := [name for name in columns if header.count(name) > 1]:
        raise RecordingError(f"{path}: has several columns {', '.join(double)}")


def _otherwise(path: Path) -> Rows:
    """A table as it would be read with the delimiter that it seems to have; its rows cannot be read."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
        return opened(stream)


def _values(
    path: Path, table: Rows, places: list[tuple[int, Callable[[str], float]]]
) -> tuple[list[Floats], list[str]]:
    """Each column's values by its place and by what reads its fields."""
    values = [array("d") for _ in places]
    short, width = 0, len(table.names)
    for line, row in enumerate(table.rows, start=table.first_line):
        if short:
            raise RecordingError(f"{path}: line {short} has fewer fields than the header")
        if not row:
            continue
        if len(row) < width:
            short = line
            continue
        if any(field.strip() for field in row[width:]):
            raise RecordingError(f"{path}: line {line} has {len(row)} fields, the header {width}")
        for value, (place, read) in zip(values, places, strict=True):
            try:
                value.append(read(row[place]))
            except (ValueError, OverflowError):
                value.append(_empty(path, line, row[place], read is as_date))
    remarks = [f"the last line ({short}) is cut and left out"] if short else []
    return [np.array(value) for value in values], remarks


def _number(decimal: str) -> Callable[[str], float]:
    return float if decimal == "." else lambda text: float(text.replace(decimal, "."))


def _empty(path: Path, line: int, text: str, dates: bool) -> float:
    """NaN for a field that is empty; RecordingError for one that cannot be read."""
    if text.strip().lower() in _EMPTY:
        return float("nan")
    if dates:
        raise RecordingError(f"{path}: line {line}: {text[:40]!r} is no date and time in ISO 8601")
    hint = """: the mapping wants `decimal: ","`""" if with_comma(text) else ""
    hint = f": a time like this wants `unit: {DATES}` in the mapping" if is_date(text) else hint
    raise RecordingError(f"{path}: line {line}: {text[:40]!r} is not a number{hint}")
