"""Bags for the tests, written by rosbags: by other code than the one that is tested."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
NOETIC = get_typestore(Stores.ROS1_NOETIC)
KIND = "sensor_msgs/msg/JointState"
POSE = "geometry_msgs/msg/PoseStamped"
START_NS = 1_750_000_000 * 10**9
JOINTS = ("a", "joint_two", "c")

Message = tuple[str, int, Any]  # topic, time of recording in ns, message


def header(stamp_ns: int, frame: str = "", store: Any = STORE) -> Any:
    """std_msgs/Header of this stamp."""
    time = store.types["builtin_interfaces/msg/Time"](stamp_ns // 10**9, stamp_ns % 10**9)
    kind = store.types["std_msgs/msg/Header"]
    return kind(0, time, frame) if store is NOETIC else kind(time, frame)


def joint_state(
    stamp_ns: int,
    names: Sequence[str],
    position: Sequence[float],
    velocity: Sequence[float] = (),
    effort: Sequence[float] = (),
    store: Any = STORE,
    frame: str = "",
) -> Any:
    """sensor_msgs/JointState."""
    values = [np.array(each, dtype=np.float64) for each in (position, velocity, effort)]
    return store.types[KIND](header(stamp_ns, frame, store), list(names), *values)


def pose(stamp_ns: int, numbers: Sequence[float], frame: str = "base_link") -> Any:
    """geometry_msgs/PoseStamped from x, y, z and a quaternion."""
    point = STORE.types["geometry_msgs/msg/Point"](*numbers[:3])
    turn = STORE.types["geometry_msgs/msg/Quaternion"](*numbers[3:])
    inner = STORE.types["geometry_msgs/msg/Pose"](point, turn)
    return STORE.types[POSE](header(stamp_ns, frame), inner)


def motion(
    topic: str = "/joint_states",
    count: int = 50,
    period_ns: int = 10_000_000,
    names: Sequence[str] = JOINTS,
    late_ns: int = 3_000_000,
    full: bool = False,
    store: Any = STORE,
) -> list[Message]:
    """`count` messages of a moving arm that are recorded `late_ns` after their stamp."""
    messages = []
    for i in range(count):
        stamp = START_NS + i * period_ns
        values = [0.1 * j + 0.01 * i for j in range(len(names))]
        rest = (values, values) if full else ((), ())
        messages.append((topic, stamp + late_ns, joint_state(stamp, names, values, *rest, store=store)))
    return messages


def write_bag(
    path: Path,
    messages: Iterable[Message],
    storage: StoragePlugin = StoragePlugin.MCAP,
    version: Literal[8, 9] = 9,
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """A rosbag2 folder with these messages."""
    writer = Writer(path, version=version, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, message in messages:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(connections[topic], log_ns, STORE.serialize_cdr(message, kind))
    return path


def write_ros1(
    path: Path, messages: Iterable[Message], compression: Writer1.CompressionFormat | None = None
) -> Path:
    """A ROS 1 bag with these messages."""
    writer = Writer1(path)
    if compression:
        writer.set_compression(compression)
    with writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, message in messages:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=NOETIC)
            writer.write(connections[topic], log_ns, NOETIC.serialize_ros1(message, kind))
    return path


def only_file(bag: Path, suffix: str = ".mcap") -> Path:
    """The one storage file of a bag."""
    (file,) = bag.glob(f"*{suffix}")
    return file
