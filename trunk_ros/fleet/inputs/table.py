"""LIST.csv and LIST.parquet: columns arm, time, path."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import PurePosixPath
from typing import Any

from trunk_ros.errors import ArgumentError
from trunk_ros.fleet.inputs.files import file_system, is_url

COLUMNS = ("arm", "time", "path")


def listed_in(path: str) -> Iterator[tuple[str, float, str]]:
    """Arm, time [s since the epoch] and path of each row; relative paths are from the list's own folder.

    Raises ArgumentError with the row that cannot be used.
    """
    system, place = file_system(path)
    try:
        content = system.cat_file(place)
    except OSError as error:
        raise ArgumentError(f"{path}: cannot be read ({error.strerror or error})") from None
    rows = _csv(content, path) if path.lower().endswith(".csv") else _parquet(content, path)
    folder = path.rpartition("/")[0] if is_url(path) else str(PurePosixPath(place).parent)
    for number, row in enumerate(rows, start=2):
        where = f"{path}, row {number}"
        arm, bag = (str(row[key] or "").strip() for key in ("arm", "path"))
        if not arm or not bag:
            raise ArgumentError(f"{where}: arm and path must not be empty")
        yield arm, seconds_of(row["time"], where), _absolute(bag, folder)


def _absolute(bag: str, folder: str) -> str:
    return bag if is_url(bag) or PurePosixPath(bag).is_absolute() else f"{folder}/{bag}"


def _csv(content: bytes, path: str) -> list[dict[str, Any]]:
    try:
        reader = csv.DictReader(io.StringIO(content.decode("utf-8-sig"), newline=""))
        _check([name.strip() for name in reader.fieldnames or ()], path)
        return [{str(key).strip(): value for key, value in row.items()} for row in reader]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ArgumentError(f"{path}: is no CSV ({error})") from None


def _parquet(content: bytes, path: str) -> list[dict[str, Any]]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(pa.BufferReader(content))
    except (pa.ArrowException, OSError) as error:
        raise ArgumentError(f"{path}: is no Parquet ({error})") from None
    _check(table.column_names, path)
    return list(table.select(list(COLUMNS)).to_pylist())


def _check(names: list[str], path: str) -> None:
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise ArgumentError(f"{path}: no column {', '.join(missing)}; a list has {', '.join(COLUMNS)}")


def seconds_of(value: object, where: str) -> float:
    """A time in s since the epoch: seconds, ISO 8601 (UTC where it names no zone), or none (NaN)."""
    if value is None or (isinstance(value, str) and not value.strip()):
        return math.nan
    if isinstance(value, datetime):
        return _epoch(value)
    try:
        return float(str(value))
    except ValueError:
        pass
    try:
        return _epoch(datetime.fromisoformat(str(value).strip()))
    except ValueError:
        raise ArgumentError(f"{where}: {value!r} is no time: give ISO 8601 or seconds") from None


def _epoch(when: datetime) -> float:
    return (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()
