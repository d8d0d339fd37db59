"""A node's streams: counted, guarded, and ended together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.health import Stream
from trunk_ros.nodes.graph.messages import fill, nanoseconds
from trunk_ros.nodes.graph.progress import Progress
from trunk_ros.nodes.graph.qos import DEPTH, LATCHED, RELIABLE, SENSED, mismatch
from trunk_ros.nodes.graph.reader import reader
from trunk_ros.nodes.graph.ros import JointState, SubscriptionEventCallbacks

NEAR = SECOND  # ns; a stamp further off than this is of another clock

Handler = Callable[[Any], Any]


class Streams:
    """What a node publishes and hears. ``counted``: a bringup waits for each message; none may be lost.

    ``node``: a TrunkNode. A TrunkError of a handler goes to diagnostics and the node goes on.
    """

    def __init__(self, node: Any, counted: bool):
        self.node, self.health = node, node.health
        self.counted = counted
        self.progress = Progress(node.get_fully_qualified_name())
        self._parts: list[tuple[Callable[[Any], Any], Any]] = []
        self._doubtful: dict[str, Any] = {}

    # Out

    def publish(self, kind: Any, topic: str, qos: Any = DEPTH) -> Callable[[Any], None]:
        """Create a publisher; returns a function that publishes and counts."""
        publisher = self.node.create_publisher(kind, topic, qos)
        self.own(self.node.destroy_publisher, publisher)
        name, sent = publisher.topic_name, self.progress.sent
        sent.setdefault(name, 0)

        def publish(message: Any) -> None:
            sent[name] += 1
            publisher.publish(message)

        return publish

    def publish_joints(self, topic: str, names: Sequence[str]) -> Callable[..., None]:
        """Create a publisher of JointStates; returns a function of what ``fill`` takes after the message.

        One message serves for all: publishing copies it.
        """
        publish, message = self.publish(JointState, topic), JointState(name=list(names))
        return lambda ns, *arrays: publish(fill(message, ns, *arrays))

    # In

    def sense(self, topic: str, handler: Handler, kind: Any = JointState, raw: bool = False) -> None:
        """Hear a sensor, also with best effort: the next message makes up for a loss. ``raw``: the handler
        takes the bytes.
        """
        self._listen(kind, topic, handler, RELIABLE if self.counted else SENSED, raw=raw, about=f"{topic}: ")

    def obey(self, kind: Any, topic: str, handler: Handler, raw: bool = False) -> None:
        """Hear commands, each of which counts. ``raw``: the handler takes the bytes."""
        self._listen(kind, topic, handler, RELIABLE, raw=raw)

    def latched(self, kind: Any, topic: str, handler: Handler) -> None:
        """Hear a topic that keeps its last message for latecomers; before activation too."""
        self._listen(kind, topic, handler, LATCHED, always=True)

    def _listen(
        self,
        kind: Any,
        topic: str,
        handler: Handler,
        qos: Any,
        raw: bool = False,
        always: bool = False,
        about: str = "",
    ) -> None:
        """``about`` stands before what is said of messages that cannot be used."""
        read = bytes if raw else reader(kind)
        name, received = self.node.resolve_topic_name(topic), self.progress.received

        def arrived(data: bytes) -> None:
            received[name] += 1
            if self.node.active or always:
                self.guarded(lambda: handler(read(data)), about=about)
            if self.node.simulated:
                self.node.tell()

        events = SubscriptionEventCallbacks(incompatible_qos=lambda _: self._doubt(name, qos))
        subscription = self.node.create_subscription(
            kind, topic, arrived, qos, raw=True, event_callbacks=events
        )
        self.own(self.node.destroy_subscription, subscription)
        received.setdefault(name, 0)

    def _doubt(self, topic: str, qos: Any) -> None:
        self._doubtful[topic] = qos
        self.look_after_qos()

    def look_after_qos(self) -> None:
        """Say which publishers are not heard for their quality of service, as long as there are any."""
        for topic, qos in list(self._doubtful.items()):
            words = mismatch(topic, self.node.get_publishers_info_by_topic(topic), qos)
            self.health.trouble(topic, words)
            if not words:
                del self._doubtful[topic]

    # Time of what is heard

    def watch(self, topic: str, timeout: float) -> Stream:
        """A stream whose silence diagnostics report."""
        return self.health.streams.setdefault(topic, Stream(timeout))

    def arrived(self, stream: Stream, message: Any) -> int:
        """Note a message; returns its stamp [ns], now where it has none or that of another clock."""
        stamp = self.own_time(stream, nanoseconds(message.header.stamp), self.node.now())
        self.heard(stream, stamp)
        return stamp

    def heard(self, stream: Stream, stamp: int) -> None:
        """Note that a message came: in simulated time at its stamp [ns], so that runs repeat whatever comes
        first.
        """
        stream.arrived(stamp if self.node.simulated and stamp else self.node.now())

    def own_time(self, stream: Stream, stamp: int, now: int) -> int:
        """A stamp [ns] as the node's clock would give it: ``now`` where it is missing or of another clock."""
        if not stamp:
            return now
        if abs(stamp - now) > NEAR and now >= 0:  # before the first /clock nothing is known
            topic = next(name for name, each in self.health.streams.items() if each is stream)
            way = "ahead of" if stamp > now else "behind"
            self.health.note(f"{topic} is stamped more than a second {way} the clock: taken as now")
            return now
        return stamp

    # The rest

    def own(self, destroy: Callable[[Any], Any], part: Any) -> None:
        """Have something destroyed with the streams."""
        self._parts.append((destroy, part))

    def guarded(self, function: Callable[..., Any], *arguments: Any, about: str = "") -> Any:
        """Call, and turn a TrunkError into a line on diagnostics."""
        try:
            return function(*arguments)
        except TrunkError as error:
            self.health.note(f"{about}{error}")
            return None

    def count_partners(self) -> None:
        """Note how many partners each publisher and subscription has found."""
        for destroy, part in self._parts:
            if destroy == self.node.destroy_publisher:
                self.progress.matched[">" + part.topic_name] = part.get_subscription_count()
            elif destroy == self.node.destroy_subscription:
                self.progress.matched["<" + part.topic_name] = part.get_publisher_count()

    def close(self) -> None:
        """End all of them."""
        for destroy, part in reversed(self._parts):
            destroy(part)
        self._parts.clear()
        self._doubtful.clear()
        self.health.troubles.clear()
