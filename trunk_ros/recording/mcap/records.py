"""The records of an MCAP file (mcap.dev/spec): framing, chunks, and what is whole of a damaged one."""

import struct
import zlib
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import lz4.frame

from trunk_ros.recording.messages.block import LARGEST_CHUNK, DamageError, unzstd

MAGIC = b"\x89MCAP0\r\n"
FRAME = 9  # bytes of kind and length before each record
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06
METADATA, DATA_END = 0x0C, 0x0F

Buffer: TypeAlias = bytes | memoryview
_FRAME = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQI")


class Record(NamedTuple):
    """Kind of a record and where its content lies in the buffer."""

    kind: int
    start: int
    end: int


class Schema(NamedTuple):
    """A message type and its definition."""

    id: int
    name: str
    encoding: str
    content: bytes


class Channel(NamedTuple):
    """A topic of an MCAP file with the number of its schema and what its writer noted."""

    id: int
    schema: int
    topic: str
    encoding: str
    noted: dict[str, str]


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
    foot = len(buffer) - len(MAGIC) - 20
    if foot < len(MAGIC) or bytes(buffer[-len(MAGIC) :]) != MAGIC:
        return
    (start,) = struct.unpack_from("<Q", buffer, foot)
    for record in records(buffer, start or foot, foot):
        if record.kind in (SCHEMA, CHANNEL) and record.end <= foot:
            yield record


def text(buffer: Buffer, start: int, end: int) -> tuple[str, int]:
    """A length-prefixed string and where it ends; DamageError if it does not fit before `end`."""
    if start + 4 > end:
        raise DamageError("has a record that ends too early")
    stop = start + 4 + int(struct.unpack_from("<I", buffer, start)[0])
    if stop > end:
        raise DamageError("has a record that ends too early")
    return bytes(buffer[start + 4 : stop]).decode("utf-8", "replace"), stop


def schema(buffer: Buffer, record: Record) -> Schema:
    """A schema record."""
    name, at = text(buffer, record.start + 2, record.end)
    encoding, at = text(buffer, at, record.end)
    (number,) = struct.unpack_from("<H", buffer, record.start)
    return Schema(number, name, encoding, bytes(buffer[at + 4 : record.end]))


def channel(buffer: Buffer, record: Record) -> Channel:
    """A channel record."""
    topic, at = text(buffer, record.start + 4, record.end)
    encoding, at = text(buffer, at, record.end)
    number, of_schema = struct.unpack_from("<HH", buffer, record.start)
    return Channel(number, of_schema, topic, encoding, _entries(buffer, at, record.end))


def metadata(buffer: Buffer, record: Record) -> tuple[str, dict[str, str]]:
    """Name and entries of a metadata record."""
    name, at = text(buffer, record.start, record.end)
    return name, _entries(buffer, at, record.end)


def _entries(buffer: Buffer, at: int, end: int) -> dict[str, str]:
    entries, at = {}, at + 4
    while at < end:
        key, at = text(buffer, at, end)
        entries[key], at = text(buffer, at, end)
    return entries


def chunk_span(buffer: Buffer, record: Record, end: int) -> tuple[int, int, int]:
    """(first ns, last ns, bytes when decompressed) that a chunk claims to hold; zeros where that is cut."""
    if record.start + _CHUNK.size > min(record.end, end):
        return 0, 0, 0
    first, last, size, _ = _CHUNK.unpack_from(buffer, record.start)
    return first, last, size


def open_chunk(buffer: Buffer, record: Record, end: int) -> Chunk:
    """Decompress and check a chunk of which the bytes up to `end` are there; DamageError if that fails."""
    end = min(record.end, end)
    if record.start + _CHUNK.size > end:
        raise DamageError("has a chunk that ends too early")
    *_, size, crc = _CHUNK.unpack_from(buffer, record.start)
    method, start = text(buffer, record.start + _CHUNK.size, end)
    if size > LARGEST_CHUNK:
        raise DamageError(f"has a chunk that claims {size} bytes")
    data = _decompress(buffer[start + 8 : end], method, size)
    if record.end > end:
        return Chunk(data, False)
    if len(data) != size or (crc and zlib.crc32(data) != crc):
        raise DamageError("has a chunk with a wrong checksum")
    return Chunk(data, True)


def _decompress(data: Buffer, method: str, size: int) -> bytes:
    if method == "zstd":
        return unzstd(data, size)
    if method == "lz4":
        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(bytes(data), max_length=size))
        except (RuntimeError, EOFError) as error:
            raise DamageError(f"holds lz4 data that cannot be read ({error})") from None
    if method:
        raise DamageError(f"has chunks compressed with {method[:20]!r}: zstd, lz4 or none can be read")
    return bytes(data)
