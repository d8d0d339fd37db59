"""A bag's messages in the order of their recording, byte for byte."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from trunk_ros.errors import RecordingError
from trunk_ros.recording.time_range import time_range

SECOND = 1_000_000_000


@dataclass(frozen=True)
class Topic:
    """A topic of a bag; ``profiles`` are rosbags' Qos objects."""

    name: str
    kind: str
    profiles: tuple[Any, ...]
    messages: int


class BagSource:
    """An opened bag. Use as a context; raises RecordingError for what cannot be read."""

    def __init__(self, path: str | Path, from_time: str | None = None, until: str | None = None):
        """``from_time`` and ``until`` are seconds since the start, or shares such as "70%"."""
        from rosbags.rosbag2 import Reader, ReaderError

        self.path = Path(path)
        self._errors = (ReaderError, OSError, ValueError, KeyError, TypeError)
        try:
            self._reader = Reader(self.path)
            self._reader.open()
        except self._errors as error:
            raise RecordingError(f"{path}: {one_line(error)}{self.hint()}") from None
        first, end = time_range(self.duration, from_time, until)
        self.start = self._reader.start_time + round(first * SECOND)
        self.stop = None if end == float("inf") else self._reader.start_time + round(end * SECOND)

    def hint(self) -> str:
        """What may help."""
        whole = self.path.is_dir() and not (self.path / "metadata.yaml").exists()
        return f" (python -m trunk_ros recover {self.path} may repair it)" if whole else ""

    @property
    def duration(self) -> float:
        """Length of the whole bag [s]."""
        return self._reader.duration / SECOND if self._reader.message_count else 0.0

    @property
    def topics(self) -> list[Topic]:
        """What the bag holds."""
        return [
            Topic(c.topic, c.msgtype, tuple(getattr(c.ext, "offered_qos_profiles", ())), c.msgcount)
            for c in self._reader.connections
        ]

    def messages(self, wanted: set[str]) -> Iterator[tuple[int, str, bytes]]:
        """Time of recording [ns], topic and bytes of the messages of the wanted topics."""
        connections = [c for c in self._reader.connections if c.topic in wanted]
        if not connections:
            return
        try:
            for connection, at, data in self._reader.messages(connections, self.start, self.stop):
                yield at, connection.topic, bytes(data)
        except self._errors as error:
            raise RecordingError(f"{self.path}: {one_line(error)}") from None

    def __enter__(self) -> BagSource:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._reader.close()


def one_line(error: Exception) -> str:
    """An error's words on one line."""
    return " ".join(str(error).split()) or type(error).__name__
