"""Messages from their bytes: nobody checks what others publish, and rclpy ends a node that cannot read it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from trunk_ros.nodes.graph.joints import MessageError
from trunk_ros.nodes.graph.ros import deserialize_message


def unpacked(raw: bytes, kind: Any) -> Any:
    """A message of a type. Raises MessageError for bytes that are none."""
    try:
        return deserialize_message(raw, kind)
    except Exception as error:  # the middleware raises what it likes
        said = " ".join(str(error).split())[:200]
        raise MessageError(f"{len(raw)} bytes that are no {kind.__name__} left out ({said})") from None


def if_readable(kind: Any, callback: Callable[[Any], None]) -> Callable[[bytes], None]:
    """A callback for bytes that passes on the messages among them."""

    def arrived(raw: bytes) -> None:
        try:
            message = unpacked(raw, kind)
        except MessageError:
            return
        callback(message)

    return arrived
