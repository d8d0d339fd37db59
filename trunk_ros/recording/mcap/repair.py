"""Writes what is whole of an MCAP file anew, with index and footer, and says what is missing."""

import struct
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Metadata, Schema, Statistics
from mcap.writer import Writer

from trunk_ros.recording.allowance import Allowance
from trunk_ros.recording.mcap import records as mcap
from trunk_ros.recording.messages.block import DamageError, mapped

_ATTACHMENT = 0x09
_HEAD = struct.Struct("<HIQQ")


class Promised(NamedTuple):
    """What a file held when it was whole: messages, first and last time of recording [ns]."""

    messages: int
    first_ns: int
    last_ns: int


@dataclass
class Loss:
    """What is kept and what is missing. Where nobody promised what the file holds, lost and lost_s are those
    of the damaged chunks alone.
    """

    messages: int = 0
    lost: int = 0
    lost_s: float = 0.0
    lost_bytes: int = 0
    skipped: int = 0
    ended: bool = False
    """Whether the file had an end, so that only its index may have been damaged."""
    promised: bool = False
    """Whether it is known what the file held."""

    def sentence(self) -> str:
        """What was kept and lost."""
        kept = f"{self.messages} messages kept"
        if not self.lost_bytes and not self.skipped:
            more = "its index is made anew" if self.ended else "what its recorder still had in memory is lost"
            return f"{kept}, all that the file held; {more}"
        parts = [f"{self.lost_bytes} bytes broke off"] if self.lost_bytes else []
        parts += [f"{self.skipped} damaged chunks left out"] if self.skipped else []
        more = ", and what followed" if self.lost_bytes and not self.promised else ""
        return f"{kept}; lost: about {self.lost} messages, {self.lost_s:.3g} s{more} ({', '.join(parts)})"


def is_whole(path: Path) -> bool:
    """Whether readers that need the index can open the file."""
    try:
        with path.open("rb") as stream:
            summary = make_reader(stream).get_summary()
            stream.seek(-len(mcap.MAGIC), 2)
            return summary is not None and summary.statistics is not None and stream.read() == mcap.MAGIC
    except Exception:  # the mcap package raises whatever its parsing runs into
        return False


def repair(source: Path, target: Path, promised: Promised | None = None) -> Loss:
    """Copy all whole records of `source` to the new file `target`. DamageError if it is no MCAP file.

    promised: what the file should hold; by default what its own summary says, if it is there.
    """
    data = mapped(source)
    if bytes(data[:8]) != mcap.MAGIC:
        raise DamageError("is not an MCAP file")
    with target.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="trunk_ros")
        copy = _Copy(writer, Allowance(source))
        for record in mcap.repeated(data):
            copy.record(data, record)
        position = 8
        for record in mcap.records(data, 8, len(data)):
            if record.kind in (mcap.FOOTER, mcap.DATA_END):
                position, copy.loss.ended = len(data), True
                break
            copy.record(data, record)
            position = min(record.end, len(data)) if record.end <= len(data) else record.start - 9
        copy.loss.lost_bytes = len(data) - position
        copy.settle(promised or _summed_up(data))
        writer.finish()  # type: ignore[no-untyped-call]
    return copy.loss


def _summed_up(data: mcap.Buffer) -> Promised | None:
    """What the summary says that the file holds."""
    for record in mcap.summary(data):
        if record.kind == mcap.STATISTICS:
            with suppress(DamageError):
                told = mcap.parsed(data, record, Statistics)
                return Promised(told.message_count, told.message_start_time, told.message_end_time)
    return None


@dataclass
class _Copy:
    """Copies records; numbers of schemas and channels change, times and sequences stay."""

    writer: Writer
    allowance: Allowance
    loss: Loss = field(default_factory=Loss)
    schemas: dict[int, int] = field(default_factory=dict)
    channels: dict[int, int] = field(default_factory=dict)
    copied: int = 0
    missing: int = 0
    """Bytes of damaged chunks, unpacked, that were not copied."""
    newest: int = 0
    """ns, of the last message that is kept or was announced."""

    def record(self, data: mcap.Buffer, record: mcap.Record) -> None:
        """Copy one record of the file; of a chunk that is cut what is whole in it."""
        if record.kind == mcap.CHUNK:
            self._chunk(data, record)
        elif record.end > len(data):
            self.loss.lost += record.kind == mcap.MESSAGE
        else:
            self.newest = max(self.newest, self._plain(data, record))

    def _chunk(self, data: mcap.Buffer, record: mcap.Record) -> None:
        first, last, size = mcap.chunk_span(data, record, len(data))
        try:
            content = mcap.open_chunk(data, record, len(data), self.allowance).data
        except DamageError:
            self.loss.skipped += record.end <= len(data)
            content = b""
        end, newest = 0, first
        for inner in mcap.records(content, 0, len(content)):
            if inner.end > len(content):
                break
            newest = max(newest, self._plain(content, inner))
            end = inner.end
        self.copied += end
        if end < size:
            self.missing += size - end
            self.loss.lost_s += max(0, last - newest) / 1e9
        self.newest = max(self.newest, newest, last)

    def settle(self, promised: Promised | None) -> None:
        """Say how much is lost, once all is copied: without a promise by the mean size of what was read."""
        if self.missing:
            here = self.missing * self.loss.messages / self.copied if self.copied else 0.0
            self.loss.lost += max(1, round(here))
        damaged = self.missing or self.loss.skipped or self.loss.lost_bytes
        if damaged and promised is not None and promised.messages > self.loss.messages:
            self.loss.promised = True
            self.loss.lost = promised.messages - self.loss.messages
            rest = self.loss.lost_s + max(0, promised.last_ns - self.newest) / 1e9
            self.loss.lost_s = min(rest, (promised.last_ns - promised.first_ns) / 1e9)

    def _plain(self, data: mcap.Buffer, record: mcap.Record) -> int:
        """Copy a record that is whole; the log time of a message, else 0."""
        try:
            if record.kind == mcap.SCHEMA:
                self._schema(mcap.parsed(data, record, Schema))
            elif record.kind == mcap.CHANNEL:
                self._channel(mcap.parsed(data, record, Channel))
            elif record.kind == mcap.MESSAGE:
                return self._message(data, record)
            elif record.kind == mcap.METADATA:
                noted = mcap.parsed(data, record, Metadata)
                if noted.name != "rosbag2":  # counts of a file that was longer
                    self.writer.add_metadata(noted.name, noted.metadata)
            elif record.kind == _ATTACHMENT:
                held = mcap.parsed(data, record, Attachment)
                self.writer.add_attachment(
                    held.create_time, held.log_time, held.name, held.media_type, held.data
                )
        except DamageError:
            self.loss.skipped += 1
        return 0

    def _schema(self, schema: Schema) -> None:
        if schema.id not in self.schemas:
            made = self.writer.register_schema(schema.name, schema.encoding, schema.data)
            self.schemas[schema.id] = int(made)

    def _channel(self, channel: Channel) -> None:
        if channel.id not in self.channels:
            schema = self.schemas.get(channel.schema_id, 0)
            described = channel.topic, channel.message_encoding, schema, channel.metadata
            made = self.writer.register_channel(*described)
            self.channels[channel.id] = int(made)

    def _message(self, data: mcap.Buffer, record: mcap.Record) -> int:
        if record.end - record.start < _HEAD.size:
            raise DamageError("has a message that ends too early")
        number, sequence, log_ns, publish_ns = _HEAD.unpack_from(data, record.start)
        if number not in self.channels:
            raise DamageError("has a message of no channel")
        content = bytes(data[record.start + _HEAD.size : record.end])
        self.writer.add_message(self.channels[number], log_ns, content, publish_ns, sequence)
        self.loss.messages += 1
        return int(log_ns)
