"""What a recording unpacks to, for rosbags, which knows no bounds: all is unpacked once, and nothing kept."""

import bz2
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import lz4.frame
import zstandard

from trunk_ros.recording.allowance import Allowance
from trunk_ros.recording.bag import ros1 as ros1_file
from trunk_ros.recording.bag import sqlite as sqlite_file
from trunk_ros.recording.mcap import records as mcap_records
from trunk_ros.recording.mcap.verify import check_index
from trunk_ros.recording.messages.block import DamageError, mapped

_PIECE = 1 << 20


def check_growth(file: Path, magic: bytes, allowance: Allowance) -> None:
    """Take from the allowance what a file that begins so becomes. RecordingError: that is too much.

    DamageError: it has parts that only its index leads to.
    """
    _GROWTH[magic](file, allowance)


def _mcap(file: Path, allowance: Allowance) -> None:
    data = mapped(file)
    for record in mcap_records.records(data, len(mcap_records.MAGIC), len(data)):
        if record.kind == mcap_records.CHUNK and record.end <= len(data):
            method, _, _, start = mcap_records.packing(data, record, len(data))
            _unpack(method, data[start : record.end], allowance)
    check_index(data)


def _ros1(file: Path, allowance: Allowance) -> None:
    data = mapped(file)
    begins, listed = set[int](), set[int]()
    for record in ros1_file.records(data, len(ros1_file.MAGIC)):
        begins.add(record.begin)
        if record.kind == ros1_file.HEADER:
            listed.update(record.number(b"index_pos", "<Q"))
        elif record.kind == ros1_file.CHUNK_INFO:
            listed.update(record.number(b"chunk_pos", "<Q"))
        elif record.kind == ros1_file.CHUNK:
            method = record.head.get(b"compression", b"").decode(errors="replace")
            _unpack(method, data[record.start : record.end], allowance)
    if not listed <= begins | {0}:  # 0: its recorder was killed
        raise DamageError("has an index that leads to no chunk")


def _sqlite(file: Path, allowance: Allowance) -> None:
    allowance.take(sqlite_file.message_bytes(file, allowance))


_GROWTH = {mcap_records.MAGIC: _mcap, sqlite_file.MAGIC: _sqlite, ros1_file.MAGIC: _ros1}


def _unpack(method: str, data: memoryview, allowance: Allowance) -> None:
    """Count what becomes of compressed bytes. What cannot be read the reader itself will refuse."""
    if method not in _OPENED:
        return
    try:
        with _OPENED[method](BytesIO(data)) as stream:
            while piece := stream.read(_PIECE):
                allowance.take(len(piece))
    except (zstandard.ZstdError, RuntimeError, OSError, EOFError, ValueError):
        return


_OPENED: dict[str, Callable[[BytesIO], Any]] = {
    "zstd": lambda data: zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True),
    "lz4": lz4.frame.open,
    "bz2": bz2.open,
}
