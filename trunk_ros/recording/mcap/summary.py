"""The last part of an MCAP file: what it holds and where (mcap.dev/spec, "Summary Section")."""

import zlib
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Footer, MetadataIndex, Schema, Statistics, SummaryOffset

INDEX_HEAD = 15  # bytes of a message index before its entries, which are of 16


def bytes_of(*records: Any) -> bytes:
    """Records one after the other as they are in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def counts_of(chunk: ChunkIndex) -> Counter[int]:
    """Messages of a chunk by channel, from the lengths of its message indexes."""
    end = chunk.chunk_start_offset + chunk.chunk_length + chunk.message_index_length
    spans = pairwise([*chunk.message_index_offsets.values(), end])
    sizes = zip(chunk.message_index_offsets, spans, strict=True)
    return Counter({channel: (stop - start - INDEX_HEAD) // 16 for channel, (start, stop) in sizes})


def summary(
    begin: int,
    schemas: Sequence[Schema],
    channels: Sequence[Channel],
    chunks: Sequence[ChunkIndex],
    metadata: Sequence[MetadataIndex],
    counts: Counter[int],
) -> bytes:
    """Summary, offsets and footer of a file in which they begin at byte `begin`."""
    statistics = Statistics(
        attachment_count=0,
        channel_count=len(channels),
        channel_message_counts={channel: count for channel, count in counts.items() if count},
        chunk_count=len(chunks),
        message_count=sum(counts.values()),
        metadata_count=len(metadata),
        message_start_time=min((chunk.message_start_time for chunk in chunks), default=0),
        message_end_time=max((chunk.message_end_time for chunk in chunks), default=0),
        schema_count=len(schemas),
    )
    groups: dict[Opcode, Sequence[Any]] = {
        Opcode.SCHEMA: schemas,
        Opcode.CHANNEL: channels,
        Opcode.STATISTICS: [statistics],
        Opcode.CHUNK_INDEX: chunks,
        Opcode.METADATA_INDEX: metadata,
    }
    data, offsets = b"", []
    for kind, records in groups.items():
        if records:
            part = bytes_of(*records)
            offsets.append(SummaryOffset(kind, begin + len(data), len(part)))
            data += part
    return _closed(begin, data, offsets)


def _closed(begin: int, data: bytes, offsets: list[SummaryOffset]) -> bytes:
    at = begin + len(data)
    data += bytes_of(*offsets)
    unchecked = bytes_of(Footer(begin, at, 0))[:-4]
    return data + bytes_of(Footer(begin, at, zlib.crc32(data + unchecked)))
