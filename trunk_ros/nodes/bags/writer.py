"""Writes a bag beside the node's loop: bounded queue, thread, MCAP chunks written within half a second."""

from __future__ import annotations

import fcntl
import os
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from trunk_ros.errors import ArgumentError
from trunk_ros.nodes.bags.folder import create_folder
from trunk_ros.recording import plain_yaml
from trunk_ros.recording.bag.metadata import BagFile, Topic, information, write_metadata
from trunk_ros.recording.mcap.write import ChunkWriter
from trunk_ros.recording.messages.message_types import qos_text

PAUSE = 0.05  # s between two looks into the queue
FLUSH = 0.4  # s that a message may wait for the disk
ROOM = 2 << 20  # bytes that stay free, so that a bag can be ended in good order
LATEST = 2**63 - 1


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
    """One topic of the bag; ``count``: its messages in the files of the bag, known when they are closed.

    ``written_qos``: the profiles as of its first message. All files and metadata.yaml have to say the same:
    rosbags finds no message of a topic of which they do not.
    """

    name: str
    type: str
    definition: str
    hash: str
    qos: list[dict[str, Any]]
    count: int = 0
    written_qos: list[dict[str, Any]] | None = None


class Entry(NamedTuple):
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
    writer: ChunkWriter
    ids: dict[str, int] = field(default_factory=dict)
    first_ns: int | None = None

    def describe(self) -> BagFile:
        """The file's entry in metadata.yaml."""
        return BagFile(self.path.name, *self.writer.span, sum(self.writer.counts.values()))


class BagWriter:
    """A bag under way. ``failure`` says why writing stopped by itself, such as a full disk."""

    def __init__(self, folder: str | Path, options: Options, noted: dict[str, str] | None = None):
        """Create the folder, which must not exist; ``noted`` is in it from then on. Raises ArgumentError."""
        self.folder = Path(folder).absolute()
        self.options = options
        self.failure = ""
        self._crash: Exception | None = None
        self._put_bytes = self._taken_bytes = 0  # each written by one thread alone
        self._channels: list[Channel] = []
        self._queue: deque[Entry] = deque()
        self._parts: list[Part] = []
        self._unchecked = 0
        self._ending = threading.Event()
        create_folder(self.folder)
        try:
            first = self._begin_part().writer
            first.note("trunk_ros", noted or {})
        except OSError as error:
            self._leave_nothing()
            raise ArgumentError(f"{self.folder} cannot be written: {error.strerror}") from None
        self._thread = threading.Thread(target=self._work, name="bag_writer", daemon=True)
        self._thread.start()

    def _leave_nothing(self) -> None:
        """Take a folder away again in which nothing can be written."""
        for part in self._parts:
            part.writer.close()
            part.path.unlink(missing_ok=True)
        with suppress(OSError):
            self.folder.rmdir()

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

    def close(self, custom: Callable[[], dict[str, str]]) -> None:
        """Write what is queued, the indexes, and metadata.yaml with entries that are asked for at the end.

        Where there is no room for that, the last chunks give way. Raises what was wrong with our own doing.
        """
        self._ending.set()
        self._thread.join()
        if self._crash is not None:
            raise self._crash
        last = self._parts[-1].writer
        self._flush(last)
        while not self._finished(last, custom) and last.drop_last():
            pass
        last.close()

    def _finished(self, last: ChunkWriter, custom: Callable[[], dict[str, str]]) -> bool:
        self._count()
        noted = custom()
        described = self._describe(noted)
        text = {"serialized_metadata": plain_yaml.dump(described)}
        try:
            last.finish({"rosbag2": text, "trunk_ros": noted})
        except OSError as error:
            self._fail(error)
            return False
        try:
            write_metadata(self.folder, described)
        except OSError as error:
            self._fail(error)
            last.unfinish()
            return False
        return True

    def _count(self) -> None:
        """Note how many messages of each topic the files hold."""
        for channel in self._channels:
            written = [part.writer.counts[part.ids.get(channel.name, 0)] for part in self._parts]
            channel.count = sum(written)

    def _fail(self, error: OSError) -> None:
        self.failure = self.failure or f"{self.folder} cannot be written: {error.strerror}"

    # The thread

    def _work(self) -> None:
        try:
            self._write_all()
        except Exception as error:  # a fault of ours: the node raises it where it is seen
            self._crash, self.failure = error, f"{type(error).__name__}: {error}"
        self._queue.clear()

    def _write_all(self) -> None:
        flushed = time.monotonic()
        last = False
        while not last and not self.failure:
            last = self._ending.wait(PAUSE)
            try:
                self._drain()
            except OSError as error:
                self._fail(error)
                self._parts[-1].writer.give_up_chunk()
            if time.monotonic() - flushed > FLUSH:
                self._flush(self._parts[-1].writer)
                flushed = time.monotonic()

    def _flush(self, writer: ChunkWriter) -> None:
        try:
            writer.flush()
        except OSError as error:
            self._fail(error)
            writer.give_up_chunk()

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
            full = part.writer
            full.finish({})
            part = self._begin_part()
            full.close()
        log_ns = min(max(entry.log_ns, 0), LATEST)  # a clock may show anything
        publish_ns = min(max(entry.publish_ns, 0), LATEST)
        number = self._channel_id(part, entry.channel)
        part.writer.add_message(number, log_ns, publish_ns, entry.number & 0xFFFFFFFF, entry.data)
        part.first_ns = log_ns if part.first_ns is None else min(part.first_ns, log_ns)
        if part.writer.open_bytes >= self.options.chunk_bytes:
            part.writer.flush()

    def _is_full(self, part: Part, entry: Entry) -> bool:
        if part.first_ns is None:
            return False
        seconds, size = self.options.split_seconds, self.options.split_bytes
        if not (size and part.writer.size + part.writer.open_bytes > size) and not (
            seconds and entry.log_ns - part.first_ns >= seconds * 1e9
        ):
            return False
        part.writer.flush()
        return True

    def _begin_part(self) -> Part:
        path = self.folder / f"{self.folder.name}_{len(self._parts)}.mcap"
        writer = ChunkWriter(path, self.options.compression)
        with suppress(OSError):  # where a file system knows no locks
            fcntl.flock(writer.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        self._parts.append(Part(path, writer))
        return self._parts[-1]

    def _channel_id(self, part: Part, channel: Channel) -> int:
        if channel.name not in part.ids:
            if channel.written_qos is None:
                channel.written_qos = list(channel.qos)
            text = qos_text(channel.written_qos)
            noted = {"offered_qos_profiles": text, "topic_type_hash": channel.hash}
            described = (channel.name, channel.type, channel.definition, noted)
            part.ids[channel.name] = part.writer.add_channel(*described)
        return part.ids[channel.name]

    def _describe(self, custom: dict[str, str]) -> dict[str, Any]:
        topics = [Topic(c.name, c.type, c.count, c.hash, c.written_qos or c.qos) for c in self._channels]
        return information([part.describe() for part in self._parts], topics, custom)
