"""Writes a bag beside the node's loop: bounded queue, thread, MCAP chunks on disk within half a second."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from trunk_ros.errors import ArgumentError
from trunk_ros.recording import plain_yaml
from trunk_ros.recording.message_types import qos_text
from trunk_ros.recording.metadata import BagFile, Topic, information, write_metadata

PAUSE = 0.05  # s between two looks into the queue
FLUSH = 0.4  # s that a message may wait for the disk
ROOM = 2 << 20  # bytes that stay free, so that a bag can be ended in good order
COMPRESSION = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}


@dataclass(frozen=True)
class Options:
    """How a bag is written; 0 means no split."""

    compression: str = "zstd"
    chunk_bytes: int = 1 << 20
    buffer_bytes: int = 64 << 20
    split_bytes: int = 0
    split_seconds: float = 0.0


@dataclass
class Channel:
    """One topic of the bag."""

    name: str
    type: str
    definition: str
    hash: str
    qos: list[dict[str, Any]]
    count: int = 0


@dataclass(frozen=True)
class Entry:
    """One message on its way to the disk."""

    channel: Channel
    log_ns: int
    publish_ns: int
    number: int
    data: bytes


@dataclass
class Part:
    """One file of the bag."""

    path: Path
    writer: Any
    stream: Any
    ids: dict[str, int] = field(default_factory=dict)
    schemas: dict[str, int] = field(default_factory=dict)
    first_ns: int = 2**63 - 1
    last_ns: int = 0
    count: int = 0

    def describe(self) -> BagFile:
        """The file's entry in metadata.yaml."""
        return BagFile(self.path.name, self.first_ns if self.count else 0, self.last_ns, self.count)


class BagWriter:
    """A bag under way. ``failure`` says why writing stopped by itself, such as a full disk."""

    def __init__(self, folder: str | Path, options: Options):
        """Create the folder, which must not exist. Raises ArgumentError."""
        self.folder = Path(folder).absolute()
        self.options = options
        self.failure = ""
        self._put_bytes = self._taken_bytes = 0  # each written by one thread alone
        self._channels: list[Channel] = []
        self._queue: deque[Entry] = deque()
        self._parts: list[Part] = []
        self._unchecked = 0
        self._ending = threading.Event()
        create_folder(self.folder)
        try:
            self._begin_part()
        except OSError as error:
            raise ArgumentError(f"{self.folder} cannot be written: {error.strerror}") from None
        self._thread = threading.Thread(target=self._work, name="bag_writer", daemon=True)
        self._thread.start()

    def add_channel(self, channel: Channel) -> None:
        """Announce a topic; it is in the bag from its first message on."""
        self._channels.append(channel)

    def put(self, entry: Entry) -> bool:
        """Queue a message; False where the queue is full or writing has failed."""
        if self.failure or self.queued_bytes + len(entry.data) > self.options.buffer_bytes:
            return False
        self._put_bytes += len(entry.data)
        self._queue.append(entry)
        return True

    @property
    def queued_bytes(self) -> int:
        """What waits for the disk."""
        return self._put_bytes - self._taken_bytes

    def close(self, custom: dict[str, str]) -> None:
        """Write what is queued, the indexes, and metadata.yaml with ``custom`` entries."""
        self._ending.set()
        self._thread.join()
        try:
            described = self._describe(custom)
            for part in self._parts[-1:]:
                part.writer.add_metadata("rosbag2", {"serialized_metadata": plain_yaml.dump(described)})
                part.writer.add_metadata("trunk_ros", custom)
                part.writer.finish()
                part.stream.close()
            write_metadata(self.folder, described)
        except OSError as error:
            self.failure = self.failure or f"{self.folder} cannot be written: {error.strerror}"

    # The thread

    def _work(self) -> None:
        flushed = time.monotonic()
        while True:
            last = self._ending.wait(PAUSE)
            try:
                self._drain()
                if time.monotonic() - flushed > FLUSH:
                    self._parts[-1].writer.flush()
                    flushed = time.monotonic()
            except OSError as error:
                self.failure = f"{self.folder} cannot be written: {error.strerror}"
            if self.failure:
                self._queue.clear()
            if last:
                return

    def _drain(self) -> None:
        while self._queue and not self.failure:
            entry = self._queue.popleft()
            self._taken_bytes += len(entry.data)
            self._write(entry)
            self._unchecked += len(entry.data)
            if self._unchecked > ROOM // 4:
                self._check_room()
        self._check_room()

    def _check_room(self) -> None:
        self._unchecked = 0
        disk = os.statvfs(self.folder)
        if disk.f_bavail * disk.f_frsize < ROOM:
            self.failure = f"the disk of {self.folder} is full: the recording was ended with what it has"

    def _write(self, entry: Entry) -> None:
        part = self._parts[-1]
        if self._is_full(part, entry):
            part.writer.finish()
            part.stream.close()
            part = self._begin_part()
        part.writer.add_message(
            self._channel_id(part, entry.channel),
            entry.log_ns,
            entry.data,
            entry.publish_ns,
            entry.number & 0xFFFFFFFF,
        )
        entry.channel.count += 1
        part.count += 1
        part.first_ns, part.last_ns = min(part.first_ns, entry.log_ns), max(part.last_ns, entry.log_ns)

    def _is_full(self, part: Part, entry: Entry) -> bool:
        options = self.options
        if options.split_bytes and part.stream.tell() > options.split_bytes:
            return True
        return bool(
            options.split_seconds
            and part.count
            and entry.log_ns - part.first_ns >= options.split_seconds * 1e9
        )

    def _begin_part(self) -> Part:
        path = self.folder / f"{self.folder.name}_{len(self._parts)}.mcap"
        stream = path.open("xb")
        writer = Writer(
            stream, chunk_size=self.options.chunk_bytes, compression=COMPRESSION[self.options.compression]
        )
        writer.start(profile="ros2", library="trunk_ros")
        self._parts.append(Part(path, writer, stream))
        return self._parts[-1]

    def _channel_id(self, part: Part, channel: Channel) -> int:
        if channel.name not in part.ids:
            if channel.type not in part.schemas:
                text = channel.definition.encode()
                part.schemas[channel.type] = part.writer.register_schema(channel.type, "ros2msg", text)
            noted = {"offered_qos_profiles": qos_text(channel.qos), "topic_type_hash": channel.hash}
            part.ids[channel.name] = part.writer.register_channel(
                channel.name, "cdr", part.schemas[channel.type], noted
            )
        return part.ids[channel.name]

    def _describe(self, custom: dict[str, str]) -> dict[str, Any]:
        topics = [Topic(c.name, c.type, c.count, c.hash, c.qos) for c in self._channels]
        return information([part.describe() for part in self._parts], topics, custom)


def create_folder(folder: Path) -> None:
    """Make a bag's folder. Raises ArgumentError where it exists or cannot be made."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
    except FileExistsError:
        raise ArgumentError(f"{folder} exists: give another output") from None
    except OSError as error:
        raise ArgumentError(f"{folder} cannot be written: {error.strerror}") from None
