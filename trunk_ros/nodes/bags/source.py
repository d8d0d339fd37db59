"""A bag's messages in the order of their recording, as the bytes that are published."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any

from trunk_ros.errors import RecordingError, one_line
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.recording.bag import ros1 as ros1_file
from trunk_ros.recording.bag.bag import check_size
from trunk_ros.recording.mcap import records as mcap_records
from trunk_ros.recording.mcap.repair import is_whole, repair
from trunk_ros.recording.messages.block import DamageError
from trunk_ros.recording.time_range import time_range

HEADER = "std_msgs/msg/Header"  # the one type that ROS 2 changed and that can be converted: it has no `seq`


@dataclass(frozen=True)
class Topic:
    """A topic of a bag; ``profiles`` are rosbags' Qos objects, ``latched`` what ROS 1 knows of such."""

    name: str
    kind: str
    profiles: tuple[Any, ...]
    messages: int
    latched: bool = False


class BagSource:
    """An opened bag: rosbag2 folder, bare .mcap (also a cut one) or .db3, ROS 1 .bag. Use as a context.

    ``notes``: what was odd about it. Raises RecordingError for what cannot be read.
    """

    def __init__(self, path: str | Path, from_time: str | None = None, until: str | None = None):
        """``from_time`` and ``until`` are seconds since the start, or shares such as "70%"."""
        self.path = Path(path)
        self.notes: list[str] = []
        self._left = ExitStack()
        try:
            check_size(self.path)
            self._open()
        except RecordingError:
            self._left.close()
            raise
        except Exception as error:  # rosbags raises whatever its parsing runs into
            self._left.close()
            said = one_line(str(error)) or type(error).__name__
            raise RecordingError(f"{path}: {said}{self.hint()}") from None
        first, end = time_range(self.duration, from_time, until)
        self.start = self._reader.start_time + round(first * SECOND)
        self.stop = None if end == float("inf") else self._reader.start_time + round(end * SECOND)

    def _open(self) -> None:
        from rosbags.rosbag1 import Reader as Reader1
        from rosbags.rosbag2 import Reader as Reader2

        head = b""
        if self.path.is_file():
            with self.path.open("rb") as stream:
                head = stream.read(16)
        self.ros1 = head.startswith(ros1_file.MAGIC)
        file = self._mended() if head.startswith(mcap_records.MAGIC) else self.path
        self._reader: Any = Reader1(file) if self.ros1 else Reader2(file)
        self._left.enter_context(self._reader)
        self._connections = [each for each in self._reader.connections if self._is_known(each)]

    def _mended(self) -> Path:
        """The .mcap file, or a copy of what is whole of it."""
        if is_whole(self.path):
            return self.path
        folder = self._left.enter_context(tempfile.TemporaryDirectory())
        mended = Path(folder) / "mended.mcap"
        loss = repair(self.path, mended)
        if not loss.messages:
            raise DamageError("holds no whole message")
        self.notes.append(loss.sentence())
        return mended

    def _is_known(self, connection: Any) -> bool:
        """Whether a connection's messages can be published: those of ROS 1 where ROS 2 has the same type."""
        if not self.ros1 or same_in_ros2(connection):
            return True
        self.notes.append(f"{connection.topic} is left out: {connection.msgtype} is another type in ROS 2")
        return False

    def hint(self) -> str:
        """What may help."""
        whole = self.path.is_dir() and not (self.path / "metadata.yaml").exists()
        return f" (trunk_ros recover {self.path} may repair it)" if whole else ""

    @property
    def duration(self) -> float:
        """Length of the whole bag [s]."""
        return self._reader.duration / SECOND if self._reader.message_count else 0.0

    @property
    def topics(self) -> list[Topic]:
        """What the bag holds."""
        return [
            Topic(
                c.topic,
                c.msgtype,
                tuple(getattr(c.ext, "offered_qos_profiles", ())),
                c.msgcount,
                bool(getattr(c.ext, "latching", 0)),
            )
            for c in self._connections
        ]

    def messages(self, wanted: set[str]) -> Iterator[tuple[int, str, bytes]]:
        """Time of recording [ns], topic and CDR bytes of the messages of the wanted topics."""
        connections = [c for c in self._connections if c.topic in wanted]
        if not connections:
            return
        try:
            for connection, at, data in self._reader.messages(connections, self.start, self.stop):
                yield at, connection.topic, self._cdr(connection, data)
        except Exception as error:  # as above
            raise RecordingError(f"{self.path}: {one_line(str(error))}") from None

    def _cdr(self, connection: Any, data: Any) -> bytes:
        return bytes(jazzy().ros1_to_cdr(data, connection.msgtype) if self.ros1 else data)

    def __enter__(self) -> BagSource:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._left.close()


@cache
def jazzy() -> Any:
    """The types of ROS 2 Jazzy."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


def same_in_ros2(connection: Any) -> bool:
    """Whether the type of a ROS 1 connection, and all that it holds, has the same fields in ROS 2."""
    from rosbags.typesys import get_types_from_msg

    there = jazzy().fielddefs
    held = get_types_from_msg(connection.msgdef.data, connection.msgtype)
    return all(kind in there and (kind == HEADER or there[kind][1] == held[kind][1]) for kind in held)
