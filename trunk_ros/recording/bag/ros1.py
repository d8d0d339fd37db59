"""Reads a ROS 1 bag (format 2.0) from front to back, so that it needs no index and stops where it is cut.

Format: http://wiki.ros.org/Bags/Format/2.0
"""

import bz2
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from trunk_ros.recording.allowance import Allowance
from trunk_ros.recording.messages.block import (
    Block,
    Contents,
    DamageError,
    Progress,
    block_of,
    mapped,
    unlz4,
)

MAGIC = b"#ROSBAG V2.0\n"
HEADER, CHUNK, CHUNK_INFO = 3, 5, 6
_MESSAGE, _CONNECTION = 2, 7
_BATCH = 65536


class Record(NamedTuple):
    """Fields of a record's head, where it begins, and where its data lie."""

    head: dict[bytes, bytes]
    begin: int
    start: int
    end: int

    @property
    def kind(self) -> int:
        """What it is: one of the numbers above."""
        return int.from_bytes(self.head.get(b"op", b"")[:1], "little")

    def number(self, key: bytes, form: str) -> tuple[int, ...]:
        """Whole numbers of a field. DamageError where it is none."""
        try:
            return struct.unpack(form, self.head.get(key, b""))
        except struct.error:
            raise DamageError("has a record without its fields") from None


def _fields(data: bytes) -> dict[bytes, bytes]:
    fields, at = {}, 0
    while at + 4 <= len(data):
        end = at + 4 + int.from_bytes(data[at : at + 4], "little")
        key, _, value = data[at + 4 : end].partition(b"=")
        fields[key], at = value, end
    return fields


def records(data: memoryview, at: int = 0) -> Iterator[Record]:
    """Records of a file or a chunk from there on; the last one may end beyond it: then it is cut."""
    while at + 8 <= len(data):
        head_end = at + 4 + int.from_bytes(data[at : at + 4], "little")
        if head_end + 4 > len(data):
            return
        end = head_end + 4 + int.from_bytes(data[head_end : head_end + 4], "little")
        yield Record(_fields(bytes(data[at + 4 : head_end])), at, head_end + 4, end)
        at = end


class _Scan:
    """Connections met so far, and messages by connection until they make a block."""

    def __init__(self, wanted: Callable[[str], bool], contents: Contents) -> None:
        self.wanted, self.contents = wanted, contents
        self.topics: dict[int, tuple[str, str]] = {}
        self.pending: dict[int, tuple[list[bytes], list[int]]] = {}

    def add(self, data: memoryview, record: Record) -> None:
        """Take in a connection or a message."""
        if record.kind not in (_MESSAGE, _CONNECTION):
            return
        (number,) = record.number(b"conn", "<I")
        if record.kind == _CONNECTION:
            kind = _fields(bytes(data[record.start : record.end])).get(b"type", b"").decode(errors="replace")
            topic = record.head.get(b"topic", b"").decode(errors="replace")
            self.topics[number] = topic, kind if "/msg/" in kind else kind.replace("/", "/msg/", 1)
            self.contents.topics[topic] = self.topics[number][1]
        elif number in self.topics and self.wanted(self.topics[number][0]):
            seconds, nanoseconds = record.number(b"time", "<II")
            payloads, times = self.pending.setdefault(number, ([], []))
            payloads.append(bytes(data[record.start : record.end]))
            times.append(seconds * 10**9 + nanoseconds)

    def blocks(self) -> Iterator[Block]:
        """What is pending, as blocks."""
        for number, (payloads, times) in self.pending.items():
            yield block_of(*self.topics[number], "ros1", payloads, times)
        self.pending = {}


def read_ros1(
    path: Path, wanted: Callable[[str], bool], contents: Contents, progress: Progress
) -> Iterator[Block]:
    """Blocks of a ROS 1 bag in the order of the file; DamageError if it is none, or encrypted."""
    data = mapped(path)
    scan, whole = _Scan(wanted, contents), len(MAGIC)
    for record in records(data, len(MAGIC)):
        if record.head.get(b"encryptor"):
            raise DamageError("is encrypted")
        cut = record.end > len(data)
        whole = whole if cut else record.end
        if record.kind == CHUNK:
            _chunk(scan, record, data[record.start : record.end], cut)
            yield from scan.blocks()
            progress(min(record.end, len(data)) / len(data))
        elif not cut:
            scan.add(data, record)
            if sum(len(each[0]) for each in scan.pending.values()) >= _BATCH:
                yield from scan.blocks()
    yield from scan.blocks()
    if whole < len(data):
        contents.damage.append(f"it breaks off: of {len(data)} bytes the first {whole} are whole")


def _chunk(scan: _Scan, record: Record, data: memoryview, cut: bool) -> None:
    """Messages of a chunk; what is damaged in it is noted, and left out."""
    try:
        content = memoryview(_decompress(bytes(data), record, scan.contents.allowance))
        for inner in records(content):
            if inner.end <= len(content):
                scan.add(content, inner)
    except DamageError as error:
        if not cut:
            scan.contents.damage.append(f"it {error}; that part is left out")


def _decompress(data: bytes, record: Record, allowance: Allowance) -> bytes:
    method = record.head.get(b"compression", b"none")
    (size,) = record.number(b"size", "<I")
    if method == b"bz2":
        return _unbz2(data, allowance, size)
    if method == b"lz4":
        return unlz4(data, allowance, size)
    if method != b"none":
        raise DamageError(f"has chunks compressed with {method[:20]!r}: bz2, lz4 or none can be read")
    return data


def _unbz2(data: bytes, allowance: Allowance, size: int) -> bytes:
    try:
        plain = bz2.BZ2Decompressor().decompress(data, max_length=min(size, allowance.most))
    except (OSError, EOFError, ValueError) as error:
        raise DamageError(f"holds bz2 data that cannot be read ({error})") from None
    allowance.take(len(plain))
    return plain
