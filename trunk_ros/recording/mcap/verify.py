"""Whether an MCAP file is as its checksums and its indexes say."""

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.records import ChunkIndex, Footer, MessageIndex

from trunk_ros.recording.allowance import Allowance
from trunk_ros.recording.mcap import records as mcap
from trunk_ros.recording.mcap.repair import is_whole
from trunk_ros.recording.messages.block import DamageError, integers, mapped

_FOOTER = 20  # bytes of its content


class _Chunk(NamedTuple):
    """Bytes of a chunk, packed and unpacked, by which method, and where the index of each channel begins."""

    size: int
    packed: int
    plain: int
    method: str
    indexes: dict[int, int]


def is_intact(path: Path) -> bool:
    """Whether nothing in the file is damaged; ``is_whole`` looks at the end of the index alone.

    RecordingError where it unpacks to more than its allowance.
    """
    if not is_whole(path):
        return False
    try:
        return _is_intact(mapped(path), Allowance(path))
    except DamageError:
        return False


def _is_intact(data: memoryview, allowance: Allowance) -> bool:
    first = mcap.record_at(data, len(mcap.MAGIC), len(data))
    if first is None or first.kind != mcap.HEADER:
        return False
    content, chunks = b"", dict[int, _Chunk]()
    here = dict[int, int]()
    for record in mcap.records(data, len(mcap.MAGIC), len(data)):
        begin = record.start - mcap.FRAME
        if record.end > len(data):
            return False
        if record.kind == mcap.CHUNK:
            content = mcap.open_chunk(data, record, len(data), allowance).data
            chunks[begin] = _chunk(data, record)
            here = chunks[begin].indexes
        elif record.kind == mcap.MESSAGE_INDEX:
            index = mcap.parsed(data, record, MessageIndex)
            here[index.channel_id] = begin
            if not _is_indexed(index, content):
                return False
        elif record.kind in mcap.PARSED:
            mcap.parsed(data, record, mcap.PARSED[record.kind])
        elif record.kind == mcap.FOOTER:
            footer = mcap.parsed(data, record, Footer)
            return _is_summed_up(data, record, footer) and _listed(data, footer, begin) == chunks
    return False


def _is_indexed(index: MessageIndex, content: bytes) -> bool:
    """Whether the message index of a channel leads to its messages in a chunk."""
    entries = np.array(index.records, dtype=np.uint64).reshape(-1, 2)
    if not len(entries):
        return True
    head = mcap.FRAME + 14  # bytes up to the end of a message's log time
    if int(entries[:, 1].max()) + head > len(content):
        return False
    bytes_, start = np.frombuffer(content, dtype=np.uint8), entries[:, 1].astype(np.int64)
    seen = (
        bytes_[start] == mcap.MESSAGE,
        integers(bytes_, start + mcap.FRAME, "<u2") == index.channel_id,
        integers(bytes_, start + mcap.FRAME + 6, "<u8") == entries[:, 0].astype(np.int64),
    )
    return bool(np.all(seen))


def _is_summed_up(data: memoryview, record: mcap.Record, footer: Footer) -> bool:
    """Whether the summary is as its checksum says, where it has one."""
    summed = data[footer.summary_start or record.start - mcap.FRAME : record.end - 4]
    return not footer.summary_crc or zlib.crc32(summed) == footer.summary_crc


def check_index(data: memoryview) -> None:
    """DamageError where the summary lists what is none of the chunks, or one twice: then readers that
    trust it find in the file what one who reads from its front does not."""
    end = len(data) - len(mcap.MAGIC)
    footer = mcap.Record(mcap.FOOTER, end - _FOOTER, end)
    if footer.start < len(mcap.MAGIC) or data[end:] != mcap.MAGIC:
        return
    there = {
        record.start - mcap.FRAME: _chunk(data, record)[:-1]
        for record in mcap.records(data, len(mcap.MAGIC), len(data))
        if record.kind == mcap.CHUNK
    }
    begin = footer.start - mcap.FRAME
    for start, chunk in _indexes(data, mcap.parsed(data, footer, Footer), begin):
        if there.pop(start, None) != chunk[:-1]:
            raise DamageError("has an index that leads to no chunk (`recover` may repair it)")


def _chunk(data: memoryview, record: mcap.Record) -> _Chunk:
    """A chunk as it is, without its indexes."""
    method, packed, plain, _ = mcap.packing(data, record, len(data))
    return _Chunk(record.end - record.start + mcap.FRAME, packed, plain, method, {})


def _listed(data: memoryview, footer: Footer, end: int) -> dict[int, _Chunk]:
    """The chunks as the summary has them, by where they begin."""
    return dict(_indexes(data, footer, end))


def _indexes(data: memoryview, footer: Footer, end: int) -> Iterator[tuple[int, _Chunk]]:
    for record in mcap.records(data, footer.summary_start or end, end):
        if record.kind == mcap.CHUNK_INDEX:
            each = mcap.parsed(data, record, ChunkIndex)
            packing = each.compressed_size, each.uncompressed_size, each.compression
            yield each.chunk_start_offset, _Chunk(each.chunk_length, *packing, each.message_index_offsets)
