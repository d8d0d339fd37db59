"""Serialised messages to messages; bytes that are none are refused, whoever sent them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from trunk_ros.nodes.graph.joint_state_reader import JointStateReader
from trunk_ros.nodes.graph.joints import MessageError
from trunk_ros.nodes.graph.ros import JointState, RMWError, deserialize_message


def reader(kind: Any) -> Callable[[bytes], Any]:
    """A function from bytes [CDR] to a message of this kind, which raises MessageError for others.

    A JointState is valid until the next one is read: its message is reused.
    """
    if kind is JointState:
        return JointStateReader().read
    return lambda data: unpacked(data, kind)


def if_readable(kind: Any, callback: Callable[[Any], None]) -> Callable[[bytes], None]:
    """A callback for bytes that passes on the messages among them."""

    def arrived(data: bytes) -> None:
        try:
            message = unpacked(data, kind)
        except MessageError:
            return
        callback(message)

    return arrived


def unpacked(data: bytes, kind: Any) -> Any:
    """A message of its bytes. Raises MessageError where they are not one."""
    try:
        return deserialize_message(data, kind)
    except RMWError:
        raise MessageError(f"{len(data)} bytes that are no {kind.__name__} were left out") from None
