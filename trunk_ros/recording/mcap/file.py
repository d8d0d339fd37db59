"""Reads an MCAP file from front to back: needs neither footer nor index, and stops where it is cut."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.records import Channel, Metadata, Schema

from trunk_ros.recording.mcap import records as mcap
from trunk_ros.recording.messages.block import (
    Block,
    Bytes,
    Contents,
    DamageError,
    Progress,
    Whole,
    integers,
    mapped,
)

_BATCH = 65536
_HEAD = 22


@dataclass
class _Scan:
    """Schemas and channels met so far, and how often what was damaged and left out."""

    contents: Contents
    wanted: Callable[[str], bool]
    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    skipped: dict[str, int] = field(default_factory=lambda: defaultdict(int))

    def note(self, buffer: mcap.Buffer, record: mcap.Record) -> None:
        """Take in a schema, a channel or a metadata record; a damaged one is counted."""
        try:
            self._note(buffer, record)
        except DamageError as error:
            self.skipped[str(error)] += 1

    def _note(self, buffer: mcap.Buffer, record: mcap.Record) -> None:
        if record.kind == mcap.SCHEMA:
            schema = mcap.parsed(buffer, record, Schema)
            self.schemas[schema.id] = schema.name
        elif record.kind == mcap.CHANNEL:
            channel = mcap.parsed(buffer, record, Channel)
            self.channels[channel.id] = channel
            self.contents.topics[channel.topic] = self.schemas.get(channel.schema_id, "of no stated type")
        elif record.kind == mcap.METADATA:
            noted = mcap.parsed(buffer, record, Metadata)
            if noted.name == "trunk_ros":
                self.contents.custom.update(noted.metadata)

    def blocks(self, buffer: mcap.Buffer, starts: list[int], end: int) -> Iterator[Block]:
        """Blocks of the messages that begin at `starts` of the buffer, one after the other up to `end`."""
        if not starts:
            return
        data = np.frombuffer(buffer, dtype=np.uint8)
        span = np.array([*starts, end], dtype=np.int64)
        span = np.column_stack([span[:-1] + mcap.FRAME, span[1:]])
        span = span[span[:, 1] - span[:, 0] >= _HEAD]
        number = integers(data, span[:, 0], "<u2")
        for each in np.unique(number):
            channel = self.channels.get(int(each))
            if channel is None:
                self.skipped["has a message of no known topic"] += int((number == each).sum())
            elif self.wanted(channel.topic):
                yield self._block(data, span[number == each], channel)

    def _block(self, data: Bytes, span: Whole, channel: Channel) -> Block:
        start = span[:, 0] + _HEAD
        log_ns = integers(data, span[:, 0] + 6, "<i8")
        kind = self.contents.topics[channel.topic]
        return Block(channel.topic, kind, channel.message_encoding, data, start, span[:, 1] - start, log_ns)

    def chunk(self, data: mcap.Buffer, record: mcap.Record) -> Iterator[Block]:
        """Blocks of a chunk, of one that is cut as far as it is whole; a damaged one is left out."""
        try:
            content = mcap.open_chunk(data, record, len(data), self.contents.allowance).data
        except DamageError as error:
            if record.end <= len(data):
                self.skipped[str(error)] += 1
            return
        inner: mcap.Record | None
        at = 0
        while True:
            starts, at = mcap.messages(content, at, len(content), _BATCH)
            yield from self.blocks(content, starts, at)
            inner = mcap.record_at(content, at, len(content))
            if inner is None or inner.end > len(content):
                return
            if inner.kind == mcap.MESSAGE:
                continue
            self.note(content, inner)
            at = inner.end


def read_mcap(
    path: Path, wanted: Callable[[str], bool], contents: Contents, progress: Progress
) -> Iterator[Block]:
    """Blocks of an MCAP file in the order of the file; DamageError if it does not begin as one."""
    data = mapped(path)
    if bytes(data[:8]) != mcap.MAGIC:
        raise DamageError("is not an MCAP file")
    scan = _Scan(contents, wanted)
    for record in mcap.repeated(data):
        scan.note(data, record)
    at, ended = 8, False
    while not ended:
        starts, at = mcap.messages(data, at, len(data), _BATCH)
        yield from scan.blocks(data, starts, at)
        following = mcap.record_at(data, at, len(data))
        if following is None:
            break
        if following.kind == mcap.CHUNK:
            yield from scan.chunk(data, following)
            progress(min(following.end, len(data)) / len(data))
        if following.end > len(data):
            break
        ended = following.kind in (mcap.FOOTER, mcap.DATA_END)
        scan.note(data, following)
        at = following.end if following.kind != mcap.MESSAGE else at
    for what, count in scan.skipped.items():
        contents.damage.append(f"{count} times: it {what}; that part is left out")
    if not ended:
        whole = f"of {len(data)} bytes the first {at} are whole" if at < len(data) else "its end is missing"
        contents.damage.append(f"it breaks off: {whole}")
