"""The last minutes of some topics in memory, byte for byte, and a bag of them when one is asked for."""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path

from trunk_ros.nodes.bags.writer import BagWriter, Channel, Entry, Options
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.interfaces import message_definition
from trunk_ros.recording.messages.message_types import RELIABLE

MOST = 64 << 20  # bytes of messages


@dataclass
class LastMinutes:
    """Keeps ``seconds`` of messages, and never more than so many bytes of them."""

    seconds: float
    most: int = MOST
    _kept: deque[tuple[str, int, bytes]] = field(default_factory=deque)
    _channels: dict[str, tuple[str, str, str]] = field(default_factory=dict)
    _bytes: int = 0
    dropped: int = 0
    """Messages that had to go before their time."""

    def add_topic(self, topic: str, kind: str) -> None:
        """Announce a topic by its full name and type. Raises TrunkError for a type not installed."""
        self._channels[topic] = (kind, *message_definition(kind))

    def add(self, topic: str, now: int, data: bytes) -> None:
        """Keep a message that came at ``now`` ns."""
        if self._kept and now < self._kept[-1][1]:  # time was set back
            self.clear()
        self._kept.append((topic, now, data))
        self._bytes += len(data)
        while self._kept and now - self._kept[0][1] > self.seconds * SECOND:
            self._forget()
        while self._bytes > self.most:
            self._forget()
            self.dropped += 1

    def clear(self) -> None:
        """Forget all."""
        self._kept.clear()
        self._bytes = 0

    def _forget(self) -> None:
        self._bytes -= len(self._kept.popleft()[2])

    @property
    def first(self) -> int:
        """When the oldest message came [ns]; 0 where there is none."""
        return self._kept[0][1] if self._kept else 0

    def write(self, folder: Path, noted: dict[str, str]) -> int:
        """Write all that is kept as a bag; returns how many messages. Raises ArgumentError."""
        writer = BagWriter(folder, Options(buffer_bytes=2 * self.most), noted)
        channels = {}
        for topic, (kind, text, digest) in self._channels.items():
            channels[topic] = Channel(topic, kind, text, digest, [dict(RELIABLE)])
            writer.add_channel(channels[topic])
        for number, (topic, at, data) in enumerate(self._kept):
            writer.put(Entry(channels[topic], at, at, number, data))
        losses = {"trunk_ros.notes": json.dumps([f"{self.dropped} messages had no room"])}
        writer.close(lambda: noted | (losses if self.dropped else {}))
        return len(self._kept)
