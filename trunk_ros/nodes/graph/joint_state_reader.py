"""Serialised JointStates to messages, at a fifth of what it costs rclpy to unpack each anew."""

from __future__ import annotations

import struct
from array import array
from typing import Any

from trunk_ros.nodes.graph.joints import MessageError
from trunk_ros.nodes.graph.ros import JointState, RMWError, deserialize_message

LITTLE_ENDIAN_CDR = b"\x00\x01\x00\x00"
STAMP = slice(4, 12)
FIELDS = ("position", "velocity", "effort")


class JointStateReader:
    """Most messages of a stream differ in stamp and values only. Of the others all fields are unpacked.

    The message is the same object each time: its fields hold until the next is read.
    """

    def __init__(self) -> None:
        self._message = JointState()
        self._length = -1
        self._values: list[slice] = []
        self._same: list[tuple[slice, bytes]] = []

    def read(self, raw: bytes) -> Any:
        """The message [CDR] as a JointState. Raises MessageError for bytes that are none."""
        if len(raw) != self._length or any(raw[part] != seen for part, seen in self._same):
            self._learn(raw)
            return self._message
        message, stamp = self._message, self._message.header.stamp
        stamp.sec, stamp.nanosec = struct.unpack("<iI", raw[STAMP])
        message.position, message.velocity, message.effort = [array("d", raw[part]) for part in self._values]
        return message

    def _learn(self, raw: bytes) -> None:
        """Unpack, and note where the values are; a layout that does not prove right is not relied upon."""
        self._length = -1
        try:
            self._message = message = deserialize_message(raw, JointState)
        except RMWError:
            raise MessageError(f"{len(raw)} bytes that are no JointState were left out") from None
        values = [getattr(message, field) for field in FIELDS]
        self._values = places(message, values)
        read = [raw[part] for part in self._values]
        known = raw[: STAMP.start] == LITTLE_ENDIAN_CDR and read == [each.tobytes() for each in values]
        self._length = len(raw) if known else -1
        edges = [0, STAMP.start, STAMP.stop]
        for part in self._values:
            edges += [part.start, part.stop]
        between = [slice(begin, end) for begin, end in zip(edges[::2], [*edges[1::2], len(raw)], strict=True)]
        self._same = [(part, raw[part]) for part in between]


def places(message: Any, values: list[Any]) -> list[slice]:
    """Where each of the values is in the serialised message: CDR, with texts and counts on 4 bytes."""
    at = STAMP.stop
    for text in (message.header.frame_id, None, *message.name):
        length = 0 if text is None else len(text.encode()) + 1  # None: the number of names
        at = aligned(at + 4 + length, 4)
    found = []
    for each in values:
        begin = aligned(at + 4, 8) if each else at + 4
        found.append(slice(begin, begin + 8 * len(each)))
        at = found[-1].stop
    return found


def aligned(at: int, size: int) -> int:
    """The next place that a number of so many bytes may be at; the first 4 bytes do not count."""
    return at + (4 - at) % size
