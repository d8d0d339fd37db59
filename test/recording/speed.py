"""How fast recordings become arrays, beside rosbags: `python -m test.recording.speed [BAG]`."""

import json
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin

from test.recording.bags import KIND, NOETIC, STORE, joint_state, motion, write_bag, write_ros1
from trunk_ros.recording.messages.block import block_of
from trunk_ros.recording.messages.decode import Decoder
from trunk_ros.recording.messages.encode import encode_joints
from trunk_ros.recording.messages.layout import joint_layout
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording


def measure(bag: Path | None = None, minutes: float = 60, runs: int = 3) -> dict[str, float]:
    """Processor s and messages/s to read `bag`, or a made-up one of `minutes` at 100 Hz; best of `runs`."""
    with tempfile.TemporaryDirectory() as folder:
        if bag is None:
            bag = Path(folder) / "bag"
            write_recording(bag, five_joints(minutes))
        recording = read_recording(bag)
        messages = sum(count.messages for count in recording.counts.values())
        ours = best(lambda: read_recording(bag), runs)
        theirs = best(lambda: read_with_rosbags(bag), 1 if messages > 10**6 else runs)
    return {
        "recorded_s": recording.duration,
        "messages": messages,
        "read_s": ours,
        "messages_per_s": messages / ours,
        "rosbags_s": theirs,
        "rosbags_messages_per_s": messages / theirs,
        "times_as_fast": theirs / ours,
    }


def five_joints(minutes: float) -> Recording:
    """Four topics of five joints at 100 Hz, one of them with velocity and effort."""
    stamp = np.arange(round(6000 * minutes)) / 100
    joints = tuple(f"joint_{i}" for i in range(1, 6))
    values = np.random.default_rng(1).normal(size=(len(stamp), 5))
    plain = JointSeries(stamp, joints, values)
    full = JointSeries(stamp, joints, values, values, values)
    series = {"reference": plain, "setpoints": plain, "gearbox_states": full, "joint_states": plain}
    return Recording("made up", 1_750_000_000 * 10**9, float(stamp[-1]), series)


def read_with_rosbags(bag: Path) -> dict[str, list[np.ndarray]]:
    """The same into arrays with rosbags alone, message by message."""
    rows: dict[str, list[np.ndarray]] = {}
    with AnyReader([bag]) as reader:
        joint_states = [each for each in reader.connections if each.msgtype == "sensor_msgs/msg/JointState"]
        for connection, _, raw in reader.messages(joint_states):
            message = reader.deserialize(raw, connection.msgtype)
            stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
            row = np.concatenate([[stamp], message.position, message.velocity, message.effort])
            rows.setdefault(connection.topic, []).append(row)
    return {topic: np.array(each) for topic, each in rows.items()}


def by_kind(folder: Path, count: int = 10_000) -> dict[str, tuple[float, float, float]]:
    """Processor s a message, by storage: ours; bytes by rosbags and our decoder; rosbags alone."""
    messages = motion(count=count, full=True)
    bags = {
        "mcap": write_bag(folder / "mcap", messages),
        "sqlite3": write_bag(folder / "sqlite3", messages, StoragePlugin.SQLITE3),
        "ROS 1": write_ros1(folder / "ros1.bag", motion(count=count, full=True, store=NOETIC)),
    }
    found = {}
    for kind, bag in bags.items():
        encoding = "ros1" if kind == "ROS 1" else "cdr"
        ways = (read_recording, partial(decode_of_rosbags, encoding=encoding), read_with_rosbags)
        ours, bytes_, alone = (best(partial(way, bag), 3) / count for way in ways)
        found[kind] = (ours, bytes_, alone)
    return found


def decode_of_rosbags(bag: Path, encoding: str) -> Decoder:
    """Bytes as rosbags finds them, into arrays by our decoder."""
    with AnyReader([bag]) as reader:
        rows = [(bytes(data), at) for _, at, data in reader.messages()]
    decoder = Decoder(joint_layout)
    payloads, times = [data for data, _ in rows], [at for _, at in rows]
    decoder.add(block_of("/joint_states", KIND, encoding, payloads, times))
    return decoder


def encoding(minutes: float = 2.0) -> tuple[float, float]:
    """Processor s a message that is made of arrays: ours; rosbags. The same bytes, which is asserted."""
    series = five_joints(minutes).series["gearbox_states"]
    assert series.velocity is not None
    assert series.effort is not None
    stamp_ns = np.round(series.stamp * 1e9).astype(np.int64)
    rows = list(zip(stamp_ns.tolist(), series.position, series.velocity, series.effort, strict=True))
    names = list(series.joints)

    def alone() -> list[bytes]:
        made = (joint_state(at, names, *values) for at, *values in rows)
        return [bytes(STORE.serialize_cdr(each, KIND)) for each in made]

    assert [bytes(row) for row in encode_joints(series, stamp_ns)] == alone()
    ways = (partial(encode_joints, series, stamp_ns), alone)
    ours, theirs = (best(way, 3) / len(rows) for way in ways)
    return ours, theirs


def best(action: Callable[[], object], runs: int) -> float:
    """The shortest of several runs, processor s: what else the machine does counts little."""
    times = []
    for _ in range(runs):
        begin = time.process_time()
        action()
        times.append(time.process_time() - begin)
    return min(times)


if __name__ == "__main__":
    print(json.dumps(measure(Path(sys.argv[1]) if len(sys.argv) > 1 else None), indent=1))
