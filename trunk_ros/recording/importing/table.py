"""The columns of a CSV file that are needed, as arrays."""

import csv
import json
import re
from array import array
from collections.abc import Callable, Collection, Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from trunk_ros.errors import RecordingError
from trunk_ros.recording.importing.units import DATES
from trunk_ros.recording.recording import Floats

DELIMITERS = ";\t|"
_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_EMPTY = {"", "nan", "na", "n/a", "null", "none", "-"}


def with_comma(text: str) -> bool:
    """Whether a field is a number with a decimal comma."""
    return bool(_COMMA.fullmatch(text.strip()))


def as_date(text: str) -> float:
    """s since 1970 of a date and time in ISO 8601; UTC where it names no zone. ValueError where it is no
    such date.
    """
    date = datetime.fromisoformat(text.strip())
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def is_date(text: str) -> bool:
    """Whether a field is a date and time in ISO 8601, and no number."""
    try:
        return "-" in text and ":" in text and as_date(text) == as_date(text)
    except ValueError:
        return False


def are_numbers(names: list[str]) -> bool:
    """Whether the names of columns are numbers, as where a table has no header; whole ones that only count
    on are names.
    """
    values = [_float(name) for name in names]
    if None in values or not values:
        return False
    return values not in ([*range(len(values))], [*range(1, len(values) + 1)])


def _float(text: str) -> float | None:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return None


def read_table(
    path: Path, columns: tuple[str, ...], delimiter: str, decimal: str = ".", dates: Collection[str] = ()
) -> tuple[dict[str, Floats], list[str]]:
    """({column: (rows,)}, remarks): NaN where a field is empty; s since 1970 in columns that hold ``dates``.
    A last line that is cut is left out and said.

    RecordingError names a column that is missing and those that are there, or the line that cannot be read,
    or says that there is no header.
    """
    try:
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
            rows = csv.reader(stream, delimiter=delimiter)
            header = [name.strip() for name in next(rows, [])]
            _check(path, header, columns)
            places = [header.index(name) for name in columns]
            read = [as_date if name in dates else _number(decimal) for name in columns]
            values, remarks = _values(path, rows, list(zip(places, read, strict=True)), len(header))
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from None
    except csv.Error as error:
        raise RecordingError(f"{path}: is not CSV ({error})") from None
    if not len(values[0]):
        raise RecordingError(f"{path}: has a header and no rows")
    return dict(zip(columns, values, strict=True)), remarks


def _check(path: Path, header: list[str], columns: tuple[str, ...]) -> None:
    there = ", ".join(header)[:600]
    if are_numbers(header):
        raise RecordingError(
            f"{path}: line 1 holds numbers ({there[:60]}): put a line with the names of the columns above it"
        )
    if missing := [name for name in columns if name not in header]:
        other = [mark for mark in DELIMITERS if len(header) == 1 and mark in header[0]]
        hint = f" in one: the mapping wants `delimiter: {json.dumps(other[0])}`" if other else ""
        raise RecordingError(f"{path}: has no column {', '.join(missing)}; there are {there or 'none'}{hint}")
    if double := [name for name in columns if header.count(name) > 1]:
        raise RecordingError(f"{path}: has several columns {', '.join(double)}")


def _values(
    path: Path, rows: Iterator[list[str]], places: list[tuple[int, Callable[[str], float]]], width: int
) -> tuple[list[Floats], list[str]]:
    """Each column's values by its place and by what reads its fields."""
    values = [array("d") for _ in places]
    short = 0
    for line, row in enumerate(rows, start=2):
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
