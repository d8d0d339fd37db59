"""A node's streams: counted, guarded, and ended together."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.health import Health, Stream
from trunk_ros.nodes.graph.joint_state_reader import JointStateReader
from trunk_ros.nodes.graph.messages import fill, nanoseconds
from trunk_ros.nodes.graph.progress import Listener, Progress
from trunk_ros.nodes.graph.qos import LATCHED
from trunk_ros.nodes.graph.ros import JointState, LifecycleNode
from trunk_ros.nodes.graph.unpack import unpacked

NEAR = SECOND  # ns; a stamp further off than this is of another clock

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

    def joint_states_on(self, topic: str, names: Sequence[str]) -> Callable[..., None]:
        """Create a publisher of JointStates; returns a function of what ``fill`` takes after the message.

        One message serves for all: publishing copies it.
        """
        publish, message = self.publish_on(JointState, topic), JointState(name=list(names))
        return lambda ns, *arrays: publish(fill(message, ns, *arrays))

    def listen_to(self, kind: Any, topic: str, callback: Callable[[Any], None], raw: bool = False) -> None:
        """Subscribe and count; a TrunkError of the callback goes to diagnostics and the node goes on.

        A JointState is valid until the next one: its message is reused.
        """
        read = JointStateReader().read if kind is JointState else partial(unpacked, kind=kind)
        self._listen(kind, topic, callback if raw else lambda data: callback(read(data)), DEPTH)

    def listen_latched(self, kind: Any, topic: str, callback: Callable[[Any], None]) -> None:
        """Subscribe to a topic that keeps its last message for latecomers; heard before activation too."""
        self._listen(kind, topic, lambda data: callback(unpacked(data, kind)), LATCHED, always=True)

    def _listen(
        self,
        kind: Any,
        topic: str,
        callback: Callable[[bytes], None],
        qos: Any,
        always: bool = False,
    ) -> None:
        name, received = "", self.progress.received

        def arrived(data: bytes) -> None:
            received[name] += 1
            if self.active or always:
                self.guarded(callback, data)
            if self.simulated:
                self._tell()

        subscription = self.create_subscription(kind, topic, arrived, qos, raw=True)
        self.own(self.destroy_subscription, subscription)
        name = subscription.topic_name
        self.progress.received.setdefault(name, 0)

    def own(self, destroy: Callable[[Any], Any], part: Any) -> None:
        """Have something destroyed with the streams."""
        self._parts.append((destroy, part))

    def arrived(self, stream: Stream, message: Any) -> int:
        """Note a message; returns its stamp [ns], now where it has none or that of another clock."""
        stamp = self.own_time(nanoseconds(message.header.stamp), self.now())
        self.heard(stream, stamp)
        return stamp

    def heard(self, stream: Stream, stamp: int) -> None:
        """Note that a message came: in simulated time at its stamp [ns], so that runs repeat whatever comes
        first.
        """
        stream.arrived(stamp if self.simulated and stamp else self.now())

    def own_time(self, stamp: int, now: int) -> int:
        """A stamp [ns] as the node's clock would give it: ``now`` where it is missing or of another clock."""
        if not stamp:
            return now
        if abs(stamp - now) > NEAR and now >= 0:  # before the first /clock nothing is known
            self.health.note("a stamp is more than a second off the clock; taken as now")
            return now
        return stamp

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
