"""Writes a run as a rosbag2 folder (MCAP). Messages are stamped out of one template, which is fast."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from test.concealed.nominal import JOINTS
from test.concealed.sensing import Run, Topic

STORE = get_typestore(Stores.ROS2_JAZZY)
NAMES = {"reference": "/trunk/reference", "setpoints": "/trunk/setpoints", "joint_states": "/joint_states",
         "gearbox_states": "/trunk/gearbox_states", "tip_pose": "/trunk/tip_pose"}  # fmt: skip
STATE, POSE = "sensor_msgs/msg/JointState", "geometry_msgs/msg/PoseStamped"
_MARK = 12345.678901234567


def _header(frame: str) -> Any:
    kinds = STORE.types
    stamp = kinds["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    return kinds["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def _state(topic: Topic) -> tuple[bytes, NDArray[np.float64]]:
    """Serialised JointState full of marks, and the numbers that take their place."""
    parts = [topic[key] for key in ("position", "velocity", "effort")]
    marked = [np.full(part.shape[1], _MARK) for part in parts]
    message = STORE.types[STATE](_header(""), list(JOINTS), *marked)
    return bytes(STORE.serialize_cdr(message, STATE)), np.concatenate(parts, axis=1)


def _pose(topic: Topic) -> tuple[bytes, NDArray[np.float64]]:
    kinds = STORE.types
    point = kinds["geometry_msgs/msg/Point"](*[_MARK] * 3)
    turn = kinds["geometry_msgs/msg/Quaternion"](*[_MARK] * 4)
    message = kinds[POSE](_header("base_link"), kinds["geometry_msgs/msg/Pose"](point, turn))
    return bytes(STORE.serialize_cdr(message, POSE)), topic["pose"]


def _messages(topic: Topic) -> NDArray[np.uint8]:
    """All messages of a topic as rows of bytes."""
    template, numbers = _pose(topic) if "pose" in topic else _state(topic)
    rows = np.tile(np.frombuffer(template, np.uint8), (len(numbers), 1))
    seconds, nanoseconds = np.divmod(topic["stamp"], 10**9)
    rows[:, 4:8] = seconds.astype("<i4")[:, None].view(np.uint8)
    rows[:, 8:12] = nanoseconds.astype("<u4")[:, None].view(np.uint8)
    mark, at = np.float64(_MARK).tobytes(), 0
    for column in numbers.T:
        at = template.index(mark, at)
        rows[:, at : at + 8] = np.ascontiguousarray(column, "<f8")[:, None].view(np.uint8)
        at += 8
    return rows


def write_bag(run: Run, path: Path | str, seed: int = 0) -> None:
    """Writes the run to a new folder; log times are the stamps and up to 0.8 ms of jitter."""
    rng = np.random.default_rng(seed)
    bag = Writer(Path(path), version=9, storage_plugin=StoragePlugin.MCAP)
    bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with bag as writer:
        queue = []
        for name, topic in run.topics.items():
            kind = POSE if "pose" in topic else STATE
            where = writer.add_connection(NAMES[name], kind, typestore=STORE)
            logged = topic["stamp"] + rng.integers(100_000, 800_000, len(topic["stamp"]))
            queue += [(int(t), where, row) for t, row in zip(logged, _messages(topic), strict=True)]
        for t, where, row in sorted(queue, key=lambda entry: entry[0]):
            writer.write(where, t, row.tobytes())
