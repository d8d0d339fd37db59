"""A node's streams: counted, guarded, and ended together."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.health import Health, Stream
from trunk_ros.nodes.messages import nanoseconds
from trunk_ros.nodes.progress import Listener, Progress
from trunk_ros.nodes.qos import LATCHED
from trunk_ros.nodes.ros import LifecycleNode

DEPTH = 200  # messages that a slow partner may be behind


class StreamNode(LifecycleNode):
    """A managed node that counts what it sends and hears; ``active`` tells whether it acts."""

    simulated = False

    def __init__(self, name: str, **options: Any):
        super().__init__(name, **options)
        self.health = Health()
        self.progress = Progress(self.get_fully_qualified_name())
        self.listener: Listener | None = None
        self.active = False
        self._parts: list[tuple[Callable[[Any], Any], Any]] = []

    def now(self) -> int:
        """ns of the node's clock, which is the system's in real time."""
        return time.time_ns()

    def publish_on(self, kind: Any, topic: str, qos: Any = DEPTH) -> Callable[[Any], None]:
        """Create a publisher; returns a function that publishes and counts."""
        publisher = self.create_publisher(kind, topic, qos)
        self.own(self.destroy_publisher, publisher)
        name, sent = publisher.topic_name, self.progress.sent
        sent.setdefault(name, 0)

        def publish(message: Any) -> None:
            sent[name] += 1
            publisher.publish(message)

        return publish

    def listen_to(self, kind: Any, topic: str, callback: Callable[[Any], None], raw: bool = False) -> None:
        """Subscribe and count; a TrunkError of the callback goes to diagnostics and the node goes on."""

        def if_active(message: Any) -> None:
            if self.active:
                callback(message)

        self._listen(kind, topic, if_active, DEPTH, raw)

    def listen_latched(self, kind: Any, topic: str, callback: Callable[[Any], None]) -> None:
        """Subscribe to a topic that keeps its last message for latecomers; heard before activation too."""
        self._listen(kind, topic, callback, LATCHED, raw=False)

    def _listen(self, kind: Any, topic: str, callback: Callable[[Any], None], qos: Any, raw: bool) -> None:
        name = ""

        def arrived(message: Any) -> None:
            self.progress.received[name] += 1
            self.guarded(callback, message)
            self._tell()

        subscription = self.create_subscription(kind, topic, arrived, qos, raw=raw)
        self.own(self.destroy_subscription, subscription)
        name = subscription.topic_name
        self.progress.received.setdefault(name, 0)

    def own(self, destroy: Callable[[Any], Any], part: Any) -> None:
        """Have something destroyed with the streams."""
        self._parts.append((destroy, part))

    def arrived(self, stream: Stream, message: Any) -> int:
        """Note a message; returns its stamp [ns], in real time that of its arrival where it has none.

        In simulated time it arrives at its stamp, so that runs repeat in whatever order messages come.
        """
        stamp, now = nanoseconds(message.header.stamp), self.now()
        stream.arrived(stamp if self.simulated and stamp else now)
        return stamp or now

    def watch(self, topic: str, timeout: float) -> Stream:
        """A stream whose silence diagnostics report."""
        return self.health.streams.setdefault(topic, Stream(timeout))

    def guarded(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call, and turn a TrunkError into a line on diagnostics."""
        try:
            return function(*arguments)
        except TrunkError as error:
            self.health.note(str(error))
            return None

    def _tell(self, beat: bool = False) -> None:
        """In real time nobody waits for each message: a beat now and then is enough."""
        if self.listener is not None and (beat or self.simulated):
            self.listener(self.progress)

    def _close_streams(self) -> None:
        for destroy, part in reversed(self._parts):
            destroy(part)
        self._parts.clear()
