"""The columns of a CSV file that are needed, as arrays."""

import csv
import json
import re
from array import array
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from trunk_ros.errors import RecordingError
from trunk_ros.recording.recording import Floats

DELIMITERS = ";\t|"
_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_EMPTY = {"", "nan", "na", "n/a", "null", "none", "-"}


def with_comma(text: str) -> bool:
    """Whether a field is a number with a decimal comma."""
    return bool(_COMMA.fullmatch(text.strip()))


def read_table(
    path: Path, columns: tuple[str, ...], delimiter: str, decimal: str = "."
) -> tuple[dict[str, Floats], list[str]]:
    """({column: (rows,)}, remarks): NaN where a field is empty. A last line that is cut is left out and said.

    RecordingError names a column that is missing and those that are there, or the line that cannot be read.
    """
    try:
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
            rows = csv.reader(stream, delimiter=delimiter)
            header = [name.strip() for name in next(rows, [])]
            _check(path, header, columns)
            places = [header.index(name) for name in columns]
            values, remarks = _values(path, rows, places, len(header), decimal)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from None
    except csv.Error as error:
        raise RecordingError(f"{path}: is not CSV ({error})") from None
    if not len(values[0]):
        raise RecordingError(f"{path}: has a header and no rows")
    return dict(zip(columns, values, strict=True)), remarks


def _check(path: Path, header: list[str], columns: tuple[str, ...]) -> None:
    there = ", ".join(header)[:600]
    if missing := [name for name in columns if name not in header]:
        other = [mark for mark in DELIMITERS if len(header) == 1 and mark in header[0]]
        hint = f" in one: the mapping wants `delimiter: {json.dumps(other[0])}`" if other else ""
        raise RecordingError(f"{path}: has no column {', '.join(missing)}; there are {there or 'none'}{hint}")
    if double := [name for name in columns if header.count(name) > 1]:
        raise RecordingError(f"{path}: has several columns {', '.join(double)}")


def _values(
    path: Path, rows: Iterator[list[str]], places: list[int], width: int, decimal: str
) -> tuple[list[Floats], list[str]]:
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
        for value, place in zip(values, places, strict=True):
            value.append(_number(path, line, row[place], decimal))
    remarks = [f"the last line ({short}) is cut and left out"] if short else []
    return [np.array(value) for value in values], remarks


def _number(path: Path, line: int, text: str, decimal: str) -> float:
    try:
        return float(text if decimal == "." else text.replace(decimal, "."))
    except ValueError:
        if text.strip().lower() in _EMPTY:
            return float("nan")
        hint = """: the mapping wants `decimal: ","`""" if with_comma(text) else ""
        raise RecordingError(f"{path}: line {line}: {text[:40]!r} is not a number{hint}") from None
