"""Writes a recording as a rosbag2 folder of version 9: MCAP with zstd chunks and checksums."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.writer import Writer

from trunk_ros.errors import ArgumentError
from trunk_ros.recording import plain_yaml
from trunk_ros.recording.bag.metadata import BagFile, Topic, information, write_metadata
from trunk_ros.recording.messages.block import Bytes, Whole
from trunk_ros.recording.messages.encode import encode_joints, encode_poses
from trunk_ros.recording.messages.message_types import RELIABLE, definition, qos_text
from trunk_ros.recording.output import BAG_FILES, new_folder
from trunk_ros.recording.recording import Floats, Recording
from trunk_ros.recording.staggered import apart
from trunk_ros.recording.topics import TIP, TIP_TOPIC, TOPICS, expected_type

_LAST_NS = (2**31) * 10**9


@dataclass(frozen=True)
class _Messages:
    """One topic, serialised: stamp_ns (n,), data: n times (bytes,)."""

    topic: Topic
    stamp_ns: Whole
    data: Bytes | list[Bytes]


def write_recording(
    path: str | Path, recording: Recording, overwrite: bool = False, custom: dict[str, str] | None = None
) -> None:
    """Write all topics of `recording` to the new folder `path`, with its units, notes and `custom` entries.

    ArgumentError if it exists without `overwrite`, or cannot be written; nothing half-written is left.
    """
    if not isinstance(recording, Recording):
        given = f"{type(path).__name__}, {type(recording).__name__}"
        raise ArgumentError(f"write_recording(path, recording): got ({given}): the folder comes first")
    noted = {**recording.custom, **(custom or {})}
    if recording.units:
        noted["trunk_ros.units"] = json.dumps(recording.units)
    if recording.notes:
        noted["trunk_ros.notes"] = json.dumps(list(recording.notes))
    messages = list(_serialised(recording))
    with new_folder(path, overwrite, BAG_FILES) as folder:
        name = f"{Path(path).absolute().name}_0.mcap"
        topics = [each.topic for each in messages]
        described = information([_file(name, messages)], topics, noted)
        _write_mcap(folder / name, messages, noted, plain_yaml.dump(described))
        write_metadata(folder, described)


def _file(name: str, messages: list[_Messages]) -> BagFile:
    first = min((int(each.stamp_ns.min()) for each in messages), default=0)
    last = max((int(each.stamp_ns.max()) for each in messages), default=0)
    return BagFile(name, first, last, sum(len(each.stamp_ns) for each in messages))


def _serialised(recording: Recording) -> Iterator[_Messages]:
    for key, series in recording.series.items():
        parts = [(each, _nanoseconds(recording, each.stamp)) for each in apart(series)]
        data = [encode_joints(each, stamp_ns) for each, stamp_ns in parts]
        stamp_ns = np.concatenate([stamp_ns for _, stamp_ns in parts])
        if len(stamp_ns):
            rows = data[0] if len(data) == 1 else [row for each in data for row in each]
            yield _Messages(_topic(key, len(stamp_ns)), stamp_ns, rows)
    if recording.tip is not None and len(recording.tip.stamp):
        stamp_ns = _nanoseconds(recording, recording.tip.stamp)
        yield _Messages(_topic(TIP, len(stamp_ns)), stamp_ns, encode_poses(recording.tip, stamp_ns))


def _topic(key: str, messages: int) -> Topic:
    name = TIP_TOPIC if key == TIP else TOPICS[key]
    return Topic(f"/{name}", expected_type(key), messages, definition(expected_type(key))[1], [RELIABLE])


def _nanoseconds(recording: Recording, stamp: Floats) -> Whole:
    """(n,) ns since the epoch; ArgumentError if the stamps of ROS cannot hold them."""
    stamp_ns = recording.start_ns + np.rint(stamp * 1e9).astype(np.int64)
    if len(stamp_ns) and not 0 <= stamp_ns.min() <= stamp_ns.max() < _LAST_NS:
        raise ArgumentError(f"{recording.name}: stamps outside of 1970 to 2038 cannot be written to a bag")
    return stamp_ns


def _write_mcap(path: Path, messages: list[_Messages], custom: dict[str, str], description: str) -> None:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="trunk_ros")
        schemas = {kind: _schema(writer, kind) for kind in {each.topic.type: None for each in messages}}
        channels = [_channel(writer, each.topic, schemas[each.topic.type]) for each in messages]
        for number, row in _by_time(messages):
            stamp = int(messages[number].stamp_ns[row])
            writer.add_message(channels[number], stamp, messages[number].data[row].tobytes(), stamp)
        writer.add_metadata("rosbag2", {"serialized_metadata": description})
        if custom:
            writer.add_metadata("trunk_ros", custom)
        writer.finish()  # type: ignore[no-untyped-call]


def _schema(writer: Writer, kind: str) -> int:
    return int(writer.register_schema(kind, "ros2msg", definition(kind)[0].encode()))


def _channel(writer: Writer, topic: Topic, schema: int) -> int:
    noted = {"offered_qos_profiles": qos_text(list(topic.qos)), "topic_type_hash": topic.hash}
    return int(writer.register_channel(topic.name, topic.encoding, schema, noted))


def _by_time(messages: list[_Messages]) -> Iterator[tuple[int, int]]:
    """(topic, row) of every message in the order of the stamps."""
    if not messages:
        return iter(())
    number = np.concatenate([np.full(len(each.stamp_ns), i) for i, each in enumerate(messages)])
    row = np.concatenate([np.arange(len(each.stamp_ns)) for each in messages])
    order = np.lexsort((number, np.concatenate([each.stamp_ns for each in messages])))
    return zip(number[order].tolist(), row[order].tolist(), strict=True)
