"""A bag whose topics are others, such as one per joint, as a recording of an arm, by a mapping."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from trunk_ros.errors import RecordingError
from trunk_ros.recording.bag.columns import Columns, read_columns
from trunk_ros.recording.importing.mapping import Mapping, Quantity, load_mapping
from trunk_ros.recording.importing.units import UNITS
from trunk_ros.recording.messages.assemble import (
    first_stamp,
    joint_series,
    positioned,
    sample_times,
    several_runs,
)
from trunk_ros.recording.messages.decode import Piece
from trunk_ros.recording.recording import Counts, Floats, JointSeries, Recording
from trunk_ros.recording.remarks import series_remarks
from trunk_ros.recording.topics import TOPICS

_QUANTITIES = ("position", "velocity", "effort")


def read_bag(path: str | Path, mapping: Mapping | str | Path) -> Recording:
    """The bag at `path` as a recording in SI units; joints of topics of their own keep their own stamps.

    The stamp is that of the message's header; where a topic has none, the time of recording, which is said.
    RecordingError in one line.
    """
    path = Path(path)
    mapping = mapping if isinstance(mapping, Mapping) else load_mapping(mapping)
    if not mapping.of_bag:
        raise RecordingError(
            f"{path}: is no table but a bag, if anything, which has its own times: leave out `time` and "
            "`rate_hz`, and name columns /topic.field"
        )
    read = read_columns(path, mapping.columns)
    pieces = {key: positioned(_pieces(path, key, mapping, read)) for key in mapping.topics}
    start_ns = min(first_stamp(each) for each, _ in pieces.values())
    series: dict[str, JointSeries] = {}
    counts: dict[str, Counts] = {}
    remarks = [f"{topic}: {said}" for topic, each in read.items() if (said := _unstamped(each))]
    for key, (each, blank) in pieces.items():
        if anew := several_runs(each):
            raise RecordingError(f"{path}: {TOPICS[key]}: {anew}")
        series[key], counted, _ = joint_series(each, start_ns)
        disorder = sum(int((np.diff(piece.stamp_ns) < 0).sum()) for piece in each)
        # of each topic: they have no common order
        messages = counted.messages + blank
        counts[key] = replace(counted, messages=messages, out_of_order=disorder, blank=blank)
        series[key] = series[key].select(mapping.joints)
    duration = max(float(each.stamp[-1]) for each in series.values())
    notes = tuple(remarks + series_remarks(series, counts))
    units = {joint: unit for joint, unit in mapping.units().items() if unit != "rad"}
    return Recording(str(path), start_ns, duration, series, None, notes, units, counts=counts).checked()


def _unstamped(columns: Columns) -> str:
    return sample_times(columns.stamp_ns, columns.log_ns)[1]


def _pieces(path: Path, key: str, mapping: Mapping, read: dict[str, Columns]) -> list[Piece]:
    """The joints of each topic of the bag as one piece."""
    topics = [_topic_of(path, key, mapping, number) for number in range(len(mapping.joints))]
    pieces, place = [], 0
    for topic in dict.fromkeys(topics):
        numbers = [number for number, each in enumerate(topics) if each == topic]
        piece = _piece(mapping, key, numbers, read[topic], place)
        place += len(piece.place)
        pieces.append(piece)
    return pieces


def _piece(mapping: Mapping, key: str, numbers: list[int], columns: Columns, place: int) -> Piece:
    values = [
        _values(mapping.topics[key][name], numbers, columns) if name in mapping.topics[key] else None
        for name in _QUANTITIES
    ]
    joints = tuple(mapping.joints[number] for number in numbers)
    stamp_ns, _ = sample_times(columns.stamp_ns, columns.log_ns)
    places = place + np.arange(len(stamp_ns), dtype=np.int64)
    return Piece(joints, stamp_ns, columns.log_ns, places, *values)


def _values(quantity: Quantity, numbers: list[int], columns: Columns) -> Floats:
    """(n, joints) in SI."""
    units = [UNITS[quantity.units[number]][1] for number in numbers]
    found = [quantity.columns[number].evaluate(columns.values) for number in numbers]
    scaled: Floats = np.column_stack(found) * np.array(units)
    return scaled


def _topic_of(path: Path, key: str, mapping: Mapping, number: int) -> str:
    """The one topic of the bag that a joint's columns are of."""
    used = [quantity.columns[number].columns for quantity in mapping.topics[key].values()]
    topics = sorted({column.partition(".")[0] for columns in used for column in columns})
    if len(topics) > 1:
        raise RecordingError(
            f"{path}: {TOPICS[key]} of {mapping.joints[number]} mixes {' and '.join(topics)}, "
            "which have stamps of their own: take one topic for a joint"
        )
    return topics[0]
