"""Small files that unpack to large ones, and what reading them takes."""

from __future__ import annotations

import bz2
import json
import os
import sqlite3
import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zstandard
from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Schema,
    Statistics,
)
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from test.recording.bags import KIND, STORE, joint_state, motion, only_file, write_bag
from trunk_ros.errors import TrunkError
from trunk_ros.recording.mcap.records import MAGIC, MESSAGE
from trunk_ros.recording.mcap.summary import bytes_of
from trunk_ros.recording.messages.message_types import definition

MIB = 1 << 20
_SCHEMA = Schema(1, definition(KIND)[0].encode(), "ros2msg", KIND)


@dataclass(frozen=True)
class Cost:
    """What became of it: the error's line or "read", what the process grew by [MB], processor time [s]."""

    said: str
    megabytes: float
    seconds: float


def cost_of(action: Callable[..., object], *arguments: Any) -> Cost:
    """An action in a process of its own, so that what it takes is given back, and is seen."""
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        os.close(reader)
        Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
        before, begun = _status("VmRSS"), time.process_time()
        said = _said(action, arguments)[:2000]
        cost = [said, _status("VmHWM") - before, time.process_time() - begun]
        os.write(writer, json.dumps(cost).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as stream:
        said = stream.read()
    _, status = os.waitpid(child, 0)
    assert status == 0, f"ended with {status}"
    return Cost(*json.loads(said))


def _status(name: str) -> float:
    """A line of the kernel on this process [MB]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith(name))


def _said(action: Callable[..., object], arguments: tuple[Any, ...]) -> str:
    try:
        action(*arguments)
    except TrunkError as error:
        return str(error)
    except BaseException as error:  # what must not happen is told to the parent
        return f"{type(error).__name__}: {error}"
    return "read"


def mcap_of(path: Path, plain: bytes, kind: str = KIND) -> Path:
    """An MCAP file with one zstd chunk that holds these records after a schema and a channel 1."""
    schema, channel = Schema(1, b"", "ros2msg", kind), Channel(1, "/joint_states", "cdr", {}, 1)
    packed = zstandard.compress(plain)
    chunk = Chunk("zstd", packed, 0, 0, 0, len(plain))
    parts = bytes_of(Header("ros2", "bomb"), schema, channel, chunk, DataEnd(0), Footer(0, 0, 0))
    path.write_bytes(MAGIC + parts + MAGIC)
    return path


def message(data: bytes, log_ns: int = 0) -> bytes:
    """A message record of channel 1."""
    return struct.pack("<BQHIQQ", MESSAGE, 22 + len(data), 1, 0, log_ns, log_ns) + data


def empty_messages(folder: Path) -> Path:
    """A chunk of 128 MiB of messages without content."""
    return mcap_of(folder / "empty.mcap", message(b"") * (128 * MIB // 31))


def many_small_chunks(folder: Path) -> Path:
    """Chunks that are small each, and 256 MiB together."""
    path = folder / "chunks.mcap"
    plain = message(bytes(1000)) * (16 * MIB // 1031)
    chunk = bytes_of(Chunk("zstd", zstandard.compress(plain), 0, 0, 0, len(plain)))
    head = bytes_of(Header("ros2", "bomb"), _SCHEMA, Channel(1, "/joint_states", "cdr", {}, 1))
    path.write_bytes(MAGIC + head + 16 * chunk + bytes_of(DataEnd(0), Footer(0, 0, 0)) + MAGIC)
    return path


def long_name(folder: Path, size: int = 50 * MIB) -> Path:
    """A joint whose name is as long as that."""
    state = joint_state(1, ["a" * size], [1.0])
    return mcap_of(folder / "name.mcap", message(bytes(STORE.serialize_cdr(state, KIND))))


def many_joints(folder: Path, joints: int = 900, messages: int = 30_000) -> Path:
    """Messages of one joint each, of very many joints: a table of them is nearly empty."""
    states = [joint_state(1, [f"joint_{k:04}"], [1.0]) for k in range(joints)]
    texts = [bytearray(message(bytes(STORE.serialize_cdr(state, KIND)))) for state in states]
    plain = bytearray()
    for number in range(messages):
        text = texts[number % joints]
        text[31 + 8 : 31 + 12] = struct.pack("<I", number)  # of the stamp
        plain += text
    return mcap_of(folder / "joints.mcap", bytes(plain))


def packed_messages(folder: Path) -> Path:
    """A sqlite3 bag whose messages are compressed one by one, each to 16 MiB."""
    bag = write_bag(folder / "packed", motion(count=2), compression=CompressionMode.MESSAGE)
    only_file(bag).unlink()
    other = write_bag(folder / "plain", motion(count=2), StoragePlugin.SQLITE3)
    file = bag / "packed.db3"
    file.write_bytes(only_file(other, ".db3").read_bytes())
    with sqlite3.connect(file) as database:
        data = zstandard.compress(bytes(16 * MIB))
        (topic,) = database.execute("SELECT id FROM topics").fetchone()
        for number in range(16):
            database.execute(
                "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", (topic, number, data)
            )
    text = (bag / "metadata.yaml").read_text().replace("packed.mcap", "packed.db3")
    (bag / "metadata.yaml").write_text(
        text.replace("storage_identifier: mcap", "storage_identifier: sqlite3")
    )
    return bag


def computed_column(folder: Path) -> Path:
    """A sqlite3 file whose messages are made when they are read."""
    bag = write_bag(folder / "computed", motion(count=2), StoragePlugin.SQLITE3)
    file = only_file(bag, ".db3")
    with sqlite3.connect(file) as database:
        database.execute("DROP TABLE messages")
        database.execute(
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
            "data BLOB AS (zeroblob(100000000)))"
        )
        (topic,) = database.execute("SELECT id FROM topics").fetchone()
        database.executemany(
            "INSERT INTO messages(topic_id, timestamp) VALUES (?, ?)", [(topic, k) for k in range(64)]
        )
    return file


def packed_file(folder: Path) -> Path:
    """A compressed MCAP file of 512 MiB, nearly all zeros."""
    path = folder / "packed.mcap.zstd"
    with path.open("wb") as stream, zstandard.ZstdCompressor().stream_writer(stream) as packed:
        packed.write(MAGIC)
        for _ in range(512):
            packed.write(bytes(MIB))
    return path


def ros1_chunk(folder: Path) -> Path:
    """A ROS 1 bag whose chunk is 128 MiB of zeros."""
    data = b"".join(_zeros())
    head = b"".join(
        struct.pack("<I", len(each)) + each
        for each in (b"op=\x05", b"compression=bz2", b"size=" + struct.pack("<I", 128 * MIB))
    )
    path = folder / "chunk.bag"
    record = struct.pack("<I", len(head)) + head + struct.pack("<I", len(data)) + data
    path.write_bytes(b"#ROSBAG V2.0\n" + record)
    return path


def _zeros() -> Iterator[bytes]:
    packer = bz2.BZ2Compressor()
    for _ in range(128):
        yield packer.compress(bytes(MIB))
    yield packer.flush()


BOMBS: dict[str, Callable[[Path], Path]] = {
    each.__name__: each
    for each in (
        empty_messages,
        many_small_chunks,
        long_name,
        many_joints,
        packed_messages,
        computed_column,
        packed_file,
        ros1_chunk,
    )
}


def lying_chunk(folder: Path) -> Path:
    """A chunk of 512 MiB that says of itself, and in the index, that it holds 1000 bytes."""
    path = folder / "lying.mcap"
    packed = _zstd_zeros(512)
    path.write_bytes(_indexed(bytes_of(Chunk("zstd", packed, 0, 0, 0, 1000)), 0, len(packed), 1000))
    return path


def frames_behind_each_other(folder: Path) -> Path:
    """A chunk of many zstd frames, of which the first says that it is small."""
    path = folder / "frames.mcap"
    packed = zstandard.compress(bytes(1000)) + 8 * _zstd_zeros(64)
    path.write_bytes(_indexed(bytes_of(Chunk("zstd", packed, 0, 0, 0, 1000)), 0, len(packed), 1000))
    return path


def hidden_chunk(folder: Path) -> Path:
    """A chunk of 512 MiB inside of an attachment: only the index leads to it."""
    path = folder / "hidden.mcap"
    packed = _zstd_zeros(512)
    held = bytes_of(Chunk("zstd", packed, 0, 0, 0, 512 * MIB))
    attachment = bytes_of(Attachment(0, 0, "a", "b", held))
    path.write_bytes(_indexed(attachment, attachment.index(held), len(packed), 512 * MIB))
    return path


def chunk_listed_often(folder: Path) -> Path:
    """A chunk of 16 MiB that the index has 64 times."""
    path = folder / "often.mcap"
    packed = _zstd_zeros(16)
    chunk = bytes_of(Chunk("zstd", packed, 0, 0, 0, 16 * MIB))
    path.write_bytes(_indexed(chunk, 0, len(packed), 16 * MIB, 64))
    return path


def _zstd_zeros(mib: int) -> bytes:
    packer = zstandard.ZstdCompressor().compressobj(size=mib * MIB)
    return b"".join(packer.compress(bytes(MIB)) for _ in range(mib)) + packer.flush()


def _indexed(record: bytes, chunk_at: int, packed: int, plain: int, times: int = 1) -> bytes:
    """A file with this record, and an index that lists a chunk `chunk_at` bytes behind its begin."""
    head = MAGIC + bytes_of(Header("ros2", "bomb"))
    described = bytes_of(_SCHEMA, Channel(1, "/joint_states", "cdr", {}, 1))
    body = head + described + record + bytes_of(DataEnd(0))
    size = 9 + 8 + 8 + 8 + 4 + 4 + 4 + 8 + packed  # of the chunk's record
    at = len(head) + len(described) + chunk_at
    index = ChunkIndex(size, at, "zstd", packed, 1, 0, {1: at}, 0, plain)
    counted = Statistics(0, 1, {1: 1}, times, 1, 0, 0, 0, 1)
    summary = described + times * bytes_of(index) + bytes_of(counted)
    return body + summary + bytes_of(Footer(len(body), 0, 0)) + MAGIC


INDEX_BOMBS: dict[str, Callable[[Path], Path]] = {
    each.__name__: each for each in (lying_chunk, frames_behind_each_other, hidden_chunk, chunk_listed_often)
}


def yaml_bombs() -> dict[str, bytes]:
    """YAML that takes long or much to read."""
    return {
        "list": b"[" + b"1," * (15 * MIB) + b"1]",
        "base_60": b"a: 1" + b":0" * MIB,
        "digits": b"a: " + b"9" * MIB,
        "keys": b"{" + b",".join(b"k%d: 1" % k for k in range(700_000)) + b"}",
    }
