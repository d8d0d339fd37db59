"""Reads an MCAP file from front to back: needs neither footer nor index, and stops where it is cut."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from trunk_ros.recording import mcap_records as mcap
from trunk_ros.recording.block import Block, Bytes, Contents, DamageError, Progress, Whole, mapped

_BATCH = 65536
_HEAD = 22


@dataclass
class _Scan:
    """Schemas and channels met so far, and the messages of the buffer at hand: (channel is read later)."""

    contents: Contents
    wanted: Callable[[str], bool]
    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, mcap.Channel] = field(default_factory=dict)

    def note(self, buffer: mcap.Buffer, record: mcap.Record) -> None:
        """Take in a schema, a channel or a metadata record."""
        if record.kind == mcap.SCHEMA:
            schema = mcap.schema(buffer, record)
            self.schemas[schema.id] = schema.name
        elif record.kind == mcap.CHANNEL:
            channel = mcap.channel(buffer, record)
            self.channels[channel.id] = channel
            self.contents.topics[channel.topic] = self.schemas.get(channel.schema, "of no stated type")
        elif record.kind == mcap.METADATA:
            name, entries = mcap.metadata(buffer, record)
            if name == "trunk_ros":
                self.contents.custom.update(entries)

    def blocks(self, buffer: mcap.Buffer, spans: list[tuple[int, int]]) -> Iterator[Block]:
        """Blocks of the message records that lie at `spans` (start, end) of the buffer."""
        if not spans:
            return
        data = np.frombuffer(buffer, dtype=np.uint8)
        span = np.array(spans, dtype=np.int64)
        span = span[span[:, 1] - span[:, 0] >= _HEAD]
        number = _integers(data, span[:, 0], "<u2")
        for each in np.unique(number):
            channel = self.channels.get(int(each))
            if channel is not None and self.wanted(channel.topic):
                yield self._block(data, span[number == each], channel)

    def _block(self, data: Bytes, span: Whole, channel: mcap.Channel) -> Block:
        start = span[:, 0] + _HEAD
        log_ns = _integers(data, span[:, 0] + 6, "<i8")
        kind = self.contents.topics[channel.topic]
        return Block(channel.topic, kind, channel.encoding, data, start, span[:, 1] - start, log_ns)


def _integers(data: Bytes, start: Whole, kind: str) -> Whole:
    width = np.dtype(kind).itemsize
    rows = np.lib.stride_tricks.sliding_window_view(data, width)[start]
    return np.ascontiguousarray(rows).view(kind)[:, 0].astype(np.int64)


def read_mcap(
    path: Path, wanted: Callable[[str], bool], contents: Contents, progress: Progress
) -> Iterator[Block]:
    """Blocks of an MCAP file in the order of the file; DamageError if it does not begin as one."""
    data = mapped(path)
    if bytes(data[:8]) != mcap.MAGIC:
        raise DamageError("is not an MCAP file")
    scan, skipped = _Scan(contents, wanted), defaultdict[str, int](int)
    for record in mcap.repeated(data):
        _note(scan, data, record, skipped)
    pending: list[tuple[int, int]] = []
    ended, position = False, 8
    for record in mcap.records(data, 8, len(data)):
        cut = record.end > len(data)
        position = record.start - 9 if cut else record.end
        if record.kind == mcap.MESSAGE and not cut:
            pending.append((record.start, record.end))
        if record.kind == mcap.CHUNK or len(pending) >= _BATCH:
            yield from scan.blocks(data, pending)
            pending = []
            progress(min(record.end, len(data)) / len(data))
        if record.kind == mcap.CHUNK:
            yield from _chunk(scan, data, record, skipped)
        elif record.kind in (mcap.FOOTER, mcap.DATA_END):
            ended = True
            break
        elif not cut:
            _note(scan, data, record, skipped)
    yield from scan.blocks(data, pending)
    contents.damage += [f"{count} times: it {what}; that part is left out" for what, count in skipped.items()]
    if not ended:
        contents.damage.append(f"it breaks off: of {len(data)} bytes the first {position} are whole")


def _note(scan: _Scan, buffer: mcap.Buffer, record: mcap.Record, skipped: dict[str, int]) -> None:
    try:
        scan.note(buffer, record)
    except DamageError as error:
        skipped[str(error)] += 1


def _chunk(scan: _Scan, data: mcap.Buffer, record: mcap.Record, skipped: dict[str, int]) -> Iterator[Block]:
    try:
        chunk = mcap.open_chunk(data, record, len(data))
    except DamageError as error:
        if record.end <= len(data):
            skipped[str(error)] += 1
        return
    spans = []
    for inner in mcap.records(chunk.data, 0, len(chunk.data)):
        if inner.end > len(chunk.data):
            break
        if inner.kind == mcap.MESSAGE:
            spans.append((inner.start, inner.end))
        else:
            _note(scan, chunk.data, inner, skipped)
    yield from scan.blocks(chunk.data, spans)
