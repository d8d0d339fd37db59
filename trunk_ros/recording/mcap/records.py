"""The records of an MCAP file (mcap.dev/spec): framing, chunks, and what is whole of a damaged one."""

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import Any, NamedTuple, TypeAlias, TypeVar, cast

from mcap import records as kinds
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError

from trunk_ros.recording.allowance import Allowance
from trunk_ros.recording.messages.block import DamageError, unlz4, unzstd

MAGIC = b"\x89MCAP0\r\n"
FRAME = 9  # bytes of kind and length before each record
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06
MESSAGE_INDEX, CHUNK_INDEX, STATISTICS, METADATA, DATA_END = 0x07, 0x08, 0x0B, 0x0C, 0x0F
PARSED: dict[int, type[Any]] = {
    HEADER: kinds.Header,
    SCHEMA: kinds.Schema,
    CHANNEL: kinds.Channel,
    METADATA: kinds.Metadata,
}

Buffer: TypeAlias = bytes | memoryview
Parsed = TypeVar("Parsed")
_FRAME = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQI")


class Record(NamedTuple):
    """Kind of a record and where its content lies in the buffer."""

    kind: int
    start: int
    end: int


class Chunk(NamedTuple):
    """Content of a chunk. Where the file broke off inside it, `whole` is false."""

    data: bytes
    whole: bool


def record_at(buffer: Buffer, start: int, end: int) -> Record | None:
    """The record that begins at `start`, or None at the end; one that ends beyond `end` is cut.

    A record of kind 0 does not exist and is an end too: so look the zeros that a power cut leaves behind.
    """
    if start + FRAME > end:
        return None
    kind, size = _FRAME.unpack_from(buffer, start)
    return Record(kind, start + FRAME, start + FRAME + size) if kind else None


def records(buffer: Buffer, start: int, end: int) -> Iterator[Record]:
    """Every record that begins in buffer[start:end]; the last one may be cut."""
    while (record := record_at(buffer, start, end)) is not None:
        yield record
        start = record.end


def messages(buffer: Buffer, start: int, end: int, most: int) -> tuple[list[int], int]:
    """Where each of the messages begins that stand one after the other from `start` on, and where they end.

    This is the loop over all messages of a file: nothing else is done in it.
    """
    unpack, head = _FRAME.unpack_from, FRAME
    starts: list[int] = []
    last = end - head
    for _ in range(most):
        if start > last:
            break
        kind, size = unpack(buffer, start)
        if kind != MESSAGE or start + head + size > end:
            break
        starts.append(start)
        start += head + size
    return starts, start


def repeated(buffer: Buffer) -> Iterator[Record]:
    """Schemas and channels as the summary, if any, repeats them: the chunk with the first may be lost."""
    return (record for record in summary(buffer) if record.kind in (SCHEMA, CHANNEL))


def summary(buffer: Buffer) -> Iterator[Record]:
    """The records of the summary that are whole, if there is one."""
    foot = len(buffer) - len(MAGIC) - 20
    if foot < len(MAGIC) or bytes(buffer[-len(MAGIC) :]) != MAGIC:
        return
    (start,) = struct.unpack_from("<Q", buffer, foot)
    for record in records(buffer, start or foot, foot):
        if record.end <= foot:
            yield record


def parsed(buffer: Buffer, record: Record, kind: type[Parsed]) -> Parsed:
    """A record as the mcap package reads it; DamageError where it cannot."""
    content = bytes(buffer[record.start : record.end])
    try:
        return cast(Parsed, kind.read(ReadDataStream(BytesIO(content))))  # type: ignore[attr-defined]
    except (McapError, struct.error, ValueError):
        raise DamageError("has a record that cannot be read") from None


class Packing(NamedTuple):
    """How a chunk is compressed: by which method, bytes then and before, and where they begin."""

    method: str
    packed: int
    plain: int
    start: int


def packing(buffer: Buffer, record: Record, end: int) -> Packing:
    """What a chunk says of itself, of which the bytes up to `end` are there; DamageError where it is cut."""
    end = min(record.end, end)
    if record.start + _CHUNK.size > end:
        raise DamageError("has a chunk that ends too early")
    plain = _size(buffer, record.start + 16)
    method, start = _method(buffer, record.start + _CHUNK.size, end)
    return Packing(method, max(record.end - start, 0), plain, start)


def chunk_span(buffer: Buffer, record: Record, end: int) -> tuple[int, int, int]:
    """(first ns, last ns, bytes when decompressed) that a chunk claims to hold; zeros where that is cut."""
    if record.start + _CHUNK.size > min(record.end, end):
        return 0, 0, 0
    first, last, size, _ = _CHUNK.unpack_from(buffer, record.start)
    return first, last, size


def open_chunk(buffer: Buffer, record: Record, end: int, allowance: Allowance) -> Chunk:
    """Decompress and check a chunk of which the bytes up to `end` are there; DamageError if that fails.

    RecordingError where it becomes larger than the allowance.
    """
    end = min(record.end, end)
    method, _, size, start = packing(buffer, record, end)
    *_, crc = _CHUNK.unpack_from(buffer, record.start)
    data = _decompress(buffer[start:end], method, size, allowance)
    if record.end > end:
        return Chunk(data, False)
    if len(data) != size or _size(buffer, start - 8) != end - start or (crc and zlib.crc32(data) != crc):
        raise DamageError("has a chunk with a wrong checksum")
    return Chunk(data, True)


def _method(buffer: Buffer, at: int, end: int) -> tuple[str, int]:
    """Name of the compression of a chunk, and where its data begin."""
    if at + 4 > end:
        raise DamageError("has a chunk that ends too early")
    stop = at + 4 + int(struct.unpack_from("<I", buffer, at)[0])
    return bytes(buffer[at + 4 : min(stop, end)]).decode(errors="replace"), stop + 8


def _size(buffer: Buffer, at: int) -> int:
    return int(struct.unpack_from("<Q", buffer, at)[0])


def _decompress(data: Buffer, method: str, size: int, allowance: Allowance) -> bytes:
    if method == "zstd":
        return unzstd(data, allowance, size)
    if method == "lz4":
        return unlz4(bytes(data), allowance, size)
    if method:
        raise DamageError(f"has chunks compressed with {method[:20]!r}: zstd, lz4 or none can be read")
    return bytes(data)
