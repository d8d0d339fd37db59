"""Columns of a mapping that are fields of messages: `/motor/state.position[0]`, `/states.position[elbow]`."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from trunk_ros.errors import RecordingError, one_line
from trunk_ros.recording.bag.bag import check_size
from trunk_ros.recording.mcap.repair import is_whole
from trunk_ros.recording.messages.block import Whole
from trunk_ros.recording.recording import Floats

_STEP = re.compile(r"([A-Za-z]\w*)(?:\[([^\[\]]+)\])?")
_NUMBERS = (bool, int, float, np.bool_, np.integer, np.floating)


@dataclass(frozen=True)
class Place:
    """Where in the messages of a topic a number is. steps: fields, each with an index or a joint's name."""

    column: str
    topic: str
    steps: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Columns:
    """What was read of one topic, in its order: stamps, times of recording (n,) ns; values (n,)."""

    stamp_ns: Whole
    log_ns: Whole
    values: dict[str, Floats]


def place_of(column: str) -> Place:
    """The place that a column names. ValueError where it is none."""
    topic, dot, fields = column.partition(".")
    steps = [_STEP.fullmatch(step) for step in re.split(r"\.(?![^\[]*\])", fields)] if dot else []
    if not topic.startswith("/") or len(topic) < 2 or not steps or None in steps:
        raise ValueError(f"{column[:60]!r}: a column of a bag is /topic.field, /topic.field[0] or [joint]")
    return Place(column, topic, tuple((step[1], step[2] or "") for step in steps if step))


def read_columns(path: Path, columns: tuple[str, ...]) -> dict[str, Columns]:
    """The columns by topic. RecordingError names what is missing, and what is there."""
    try:
        places = [place_of(column) for column in columns]
        check_size(path)
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as bag:
            return _read(bag, places)
    except RecordingError:
        raise
    except Exception as error:  # rosbags raises whatever its parsing runs into
        said = one_line(str(error)) or type(error).__name__
        raise RecordingError(f"{path}: {said}{_hint(path)}") from None


def _hint(path: Path) -> str:
    """What may help with MCAP files."""
    files = [path] if path.suffix == ".mcap" and path.is_file() else list(path.glob("*.mcap"))
    return " (`recover` may repair it)" if any(not is_whole(file) for file in files) else ""


def _read(bag: AnyReader, places: list[Place]) -> dict[str, Columns]:
    wanted: dict[str, list[Place]] = {}
    for place in places:
        wanted.setdefault(place.topic, []).append(place)
    there = sorted({each.topic for each in bag.connections})
    if missing := sorted(set(wanted) - set(there)):
        raise ValueError(f"has no topic {', '.join(missing)}; there are {', '.join(there) or 'none'}")
    rows: dict[str, list[tuple[float, ...]]] = {topic: [] for topic in wanted}
    times: dict[str, list[tuple[int, int]]] = {topic: [] for topic in wanted}
    named: dict[str, dict[str, None]] = {topic: {} for topic in wanted}
    for connection, log_ns, data in bag.messages([c for c in bag.connections if c.topic in wanted]):
        message = bag.deserialize(data, connection.msgtype)
        rows[connection.topic].append(tuple(_number(message, place) for place in wanted[connection.topic]))
        times[connection.topic].append((_stamp(message), log_ns))
        named[connection.topic].update(dict.fromkeys(_names(message)))
    for topic in wanted:
        _check_names(wanted[topic], named[topic])
    return {topic: _columns(places, rows[topic], times[topic]) for topic, places in wanted.items()}


def _check_names(places: list[Place], named: Collection[str]) -> None:
    """ValueError for a name that no message of a topic has, as far as ``named`` is known."""
    for place in places:
        (_, index), *inner = place.steps
        if named and index and not inner and not index.isdecimal() and index not in named:
            raise ValueError(f"{place.column} is in no message: they name {', '.join(named)}")


def _names(message: Any) -> list[str]:
    names = getattr(message, "name", ())
    return [] if isinstance(names, str) else [str(name) for name in names]


def _columns(places: list[Place], rows: list[tuple[float, ...]], times: list[tuple[int, int]]) -> Columns:
    if not rows:
        raise ValueError(f"has no message of {places[0].topic}")
    values, at = np.array(rows, dtype=np.float64), np.array(times, dtype=np.int64)
    named = {place.column: values[:, number] for number, place in enumerate(places)}
    return Columns(at[:, 0], at[:, 1], named)


def _stamp(message: Any) -> int:
    """Stamp of a message [ns], 0 where it has none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return int(stamp.sec) * 10**9 + int(stamp.nanosec) if stamp is not None else 0


def _number(message: Any, place: Place) -> float:
    """The number at a place; NaN where a message has fewer entries, or not the joint."""
    held = message
    for field, index in place.steps:
        holder, held = held, getattr(held, field, None)
        if held is None:
            names = [each for each in _fields(holder) if not each.startswith("__")]
            raise ValueError(f"{place.topic} has no field {field}: there are {', '.join(names)}")
        if index:
            held = _entry(holder, held, index, place)
    if held is not None and not isinstance(held, _NUMBERS):
        raise ValueError(f"{place.column} is no number: give a field of it, or an index like [0]")
    return np.nan if held is None else float(held)


def _entry(holder: Any, values: Any, index: str, place: Place) -> Any:
    """An entry by number or by the joint's name; None where the message does not have it."""
    if not hasattr(values, "__len__") or isinstance(values, str):
        raise ValueError(f"{place.column}: there is no list to take [{index}] of")
    names = list(getattr(holder, "name", ()))
    if not index.isdecimal() and not names:
        raise ValueError(f"{place.column}: its messages name no joints, give a number in place of {index}")
    at = int(index) if index.isdecimal() else (names.index(index) if index in names else len(values))
    return values[at] if at < len(values) else None


def _fields(message: Any) -> Mapping[str, Any]:
    fields: Mapping[str, Any] = getattr(message, "__dataclass_fields__", {})
    return fields
