"""Writes an MCAP file (mcap.dev/spec) in steps: a chunk is in the file with its index, or not at all."""

import os
import struct
import zlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import lz4.frame
import numpy as np
import zstandard
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Header, Metadata, MetadataIndex, Schema

from trunk_ros.recording.mcap.records import MAGIC, MESSAGE
from trunk_ros.recording.mcap.summary import bytes_of, counts_of, summary

_MESSAGE = struct.Struct("<BQHIQQ")  # kind, length, channel, sequence, log ns, publish ns
_INDEX = struct.Struct("<BQHI")  # kind, length, channel, bytes of (log ns, offset)


class ChunkWriter:
    """One MCAP file. ``size``: bytes in it; ``counts``: messages in it by channel."""

    def __init__(self, path: Path, compression: str = "zstd"):
        """Create the file, which must not exist, with its head. Raises OSError.

        It has another name until the head is in it, so that no file of this name is empty.
        """
        self.compression = "" if compression == "none" else compression
        self.size = 0
        self._body: int | None = None
        self.counts: Counter[int] = Counter()
        self._schemas: dict[str, Schema] = {}
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._noted: list[MetadataIndex] = []
        draft = path.with_name(f".{path.name}")
        self.file = os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_APPEND, 0o644)
        try:
            self._append(MAGIC + bytes_of(Header("ros2", "trunk_ros")))
            draft.rename(path)
        except OSError:
            os.close(self.file)
            draft.unlink(missing_ok=True)
            raise
        self._begin_chunk()

    @property
    def span(self) -> tuple[int, int]:
        """Earliest and latest time of recording in the file [ns], zeros where there is none."""
        first = min((chunk.message_start_time for chunk in self._chunks), default=0)
        return first, max((chunk.message_end_time for chunk in self._chunks), default=0)

    def add_channel(self, topic: str, kind: str, definition: str, noted: dict[str, str]) -> int:
        """Announce a topic of messages in CDR; returns its number."""
        if kind not in self._schemas:
            number = len(self._schemas) + 1
            self._schemas[kind] = Schema(number, definition.encode(), "ros2msg", kind)
            self._put(bytes_of(self._schemas[kind]))
        channel = Channel(len(self._channels) + 1, topic, "cdr", noted, self._schemas[kind].id)
        self._channels.append(channel)
        self._put(bytes_of(channel))
        return int(channel.id)

    def add_message(self, channel: int, log_ns: int, publish_ns: int, sequence: int, data: bytes) -> None:
        """Add a message to the open chunk."""
        self._index.setdefault(channel, []).extend((log_ns, self.open_bytes))
        self._put(_MESSAGE.pack(MESSAGE, 22 + len(data), channel, sequence, log_ns, publish_ns))
        self._put(data)

    def note(self, name: str, held: dict[str, str]) -> None:
        """Write a metadata record before the first chunk. Raises OSError."""
        record = bytes_of(Metadata(metadata=held, name=name))
        index = MetadataIndex(self.size, len(record), name)
        self._append(record)
        self._noted.append(index)

    def flush(self) -> None:
        """Close the open chunk. Raises OSError: then nothing of it is in the file."""
        if not self._index:
            return
        plain = b"".join(self._parts)
        packed = _compressed(plain, self.compression)
        first, last = self._open_span()
        chunk = Chunk(
            compression=self.compression,
            data=packed,
            message_end_time=last,
            message_start_time=first,
            uncompressed_crc=zlib.crc32(plain),
            uncompressed_size=len(plain),
        )
        self._append_indexed(bytes_of(chunk), chunk)
        self.counts += counts_of(self._chunks[-1])
        self._begin_chunk()

    def give_up_chunk(self) -> None:
        """Leave out what the open chunk holds."""
        self._begin_chunk()

    def drop_last(self) -> bool:
        """Take the last chunk out of the file again, so that there is room; False where there is none."""
        if not self._chunks:
            return False
        chunk = self._chunks.pop()
        self.counts -= counts_of(chunk)
        self._cut(chunk.chunk_start_offset)
        return True

    def finish(self, metadata: Mapping[str, dict[str, str]]) -> None:
        """Write metadata records, index and footer, anew where it was finished before.

        Raises OSError: then they are not in the file.
        """
        self.unfinish()
        data, indexes = b"", list(self._noted)
        for name, held in metadata.items():
            record = bytes_of(Metadata(metadata=held, name=name))
            indexes.append(MetadataIndex(self.size + len(data), len(record), name))
            data += record
        data += bytes_of(DataEnd(0))
        rest = (list(self._schemas.values()), self._channels, self._chunks, indexes, self.counts)
        body = self.size
        self._append(data + summary(body + len(data), *rest) + MAGIC)
        self._body = body

    def unfinish(self) -> None:
        """Take out again what ``finish`` wrote."""
        if self._body is not None:
            self._cut(self._body)
            self._body = None

    def close(self) -> None:
        """Let go of the file."""
        os.close(self.file)

    # Inside

    def _begin_chunk(self) -> None:
        self._parts: list[bytes] = []
        self._index: dict[int, list[int]] = {}
        self.open_bytes = 0

    def _put(self, data: bytes) -> None:
        self._parts.append(data)
        self.open_bytes += len(data)

    def _open_span(self) -> tuple[int, int]:
        times = [(min(values[::2]), max(values[::2])) for values in self._index.values()]
        return min(first for first, _ in times), max(last for _, last in times)

    def _indexes(self, begin: int) -> tuple[dict[int, int], bytes]:
        """Where the message index of each channel begins, and all of them."""
        offsets, data = {}, b""
        for channel, values in self._index.items():
            offsets[channel] = begin + len(data)
            entries = np.array(values, dtype="<u8").tobytes()
            data += _INDEX.pack(0x07, 6 + len(entries), channel, len(entries)) + entries
        return offsets, data

    def _append_indexed(self, data: bytes, chunk: Chunk) -> None:
        begin = self.size
        offsets, indexes = self._indexes(begin + len(data))
        self._append(data + indexes)
        index = ChunkIndex(
            chunk_length=len(data),
            chunk_start_offset=begin,
            compression=self.compression,
            compressed_size=len(chunk.data),
            message_end_time=chunk.message_end_time,
            message_index_length=len(indexes),
            message_index_offsets=offsets,
            message_start_time=chunk.message_start_time,
            uncompressed_size=chunk.uncompressed_size,
        )
        self._chunks.append(index)

    def _append(self, data: bytes) -> None:
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self.file, rest) :]
        except OSError:
            self._cut(self.size)
            raise
        self.size += len(data)

    def _cut(self, size: int) -> None:
        os.ftruncate(self.file, size)
        self.size = size


def _compressed(plain: bytes, method: str) -> bytes:
    if method == "zstd":
        return zstandard.compress(plain)
    return bytes(lz4.frame.compress(plain)) if method == "lz4" else plain
