"""replay: a bag back onto topics, at its own pace, faster, or step by step; or through a node again."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

from trunk_ros.errors import ArgumentError, TrunkError
from trunk_ros.nodes.bags.replay_arguments import parser
from trunk_ros.nodes.bags.source import BagSource, Topic
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.interfaces import message_class
from trunk_ros.nodes.graph.managed import end, start
from trunk_ros.nodes.graph.messages import time_message
from trunk_ros.nodes.graph.process import DELIVERY, start_ros
from trunk_ros.nodes.graph.qos import recorded
from trunk_ros.nodes.graph.ros import (
    Clock,
    EventsExecutor,
    InvalidTopicNameException,
    SetBool,
    Trigger,
    rclpy,
    validate_full_topic_name,
)
from trunk_ros.nodes.run.plan import split_ros
from trunk_ros.nodes.stop import Stop

LAST_PARTNER = 1.0  # s without a new subscriber after which no more are expected
SETTLE = 0.5  # s after which partners know each other, and have what was sent
BURST = 50  # messages after which services are looked after, where replay is behind
DEPTH = 1000
CLOCK = "/clock"


class Replay(TrunkNode):
    """Publishes what a bag holds; ``~/pause`` (SetBool) and ``~/step`` (Trigger) while it plays."""

    NAME = "replay"

    def prepare(self, given: argparse.Namespace, topics: list[Topic]) -> None:
        """Create publishers and services. Raises TrunkError where no topic is left."""
        self.given = given
        self.paused, self.count = given.paused or given.step, 0
        self.steps = threading.Semaphore(0)  # two threads ask for steps
        names = renamed(given.remap)
        self.outlets: dict[str, Any] = {}
        for topic in topics:
            try:
                kind = message_class(topic.kind)
            except TrunkError as error:
                print(f"{given.bag}: {topic.name} is left out: {error}", file=sys.stderr)
                continue
            name = names.get(topic.name, topic.name)
            profile = recorded(topic.profiles, DEPTH, topic.latched)
            self.outlets[topic.name] = self.create_publisher(kind, name, profile)
        if not self.outlets:
            raise TrunkError(f"replay: none of the topics of {given.bag} can be published here")
        self.clock = self.create_publisher(Clock, CLOCK, 10) if given.clock else None
        self.told = 0
        self.create_service(Trigger, "~/step", self.on_step)
        self.create_service(SetBool, "~/pause", self.on_pause)

    def on_step(self, request: Any, response: Any) -> Any:
        """Publish one more message."""
        self.steps.release()
        response.success = True
        return response

    def on_pause(self, request: Any, response: Any) -> Any:
        """Stand still, or go on."""
        self.paused = request.data
        response.success = True
        return response

    def partners(self) -> tuple[int, bool]:
        """Number of subscribers, and whether every topic has one."""
        clock = [] if self.clock is None else [self.clock]
        counts = [outlet.get_subscription_count() for outlet in (*self.outlets.values(), *clock)]
        return sum(counts), all(counts)

    def publish(self, topic: str, data: bytes, at: int) -> None:
        """Publish a message of the time ``at`` [ns], and the clock before it."""
        self.tell_time(at)
        self.outlets[topic].publish(data)
        self.count += 1
        self.health.ticked()

    def tell_time(self, at: int) -> None:
        """Publish the bag's time where the clock is due."""
        if self.clock is not None and (at < self.told or at - self.told >= SECOND / self.given.clock):
            self.clock.publish(Clock(clock=time_message(at)))
            self.told = at


class Player:
    """Keeps the pace: bag time runs ``rate`` times as fast as the wall's clock while nothing pauses it."""

    def __init__(self, node: Replay, executor: Any, stop: Stop):
        self.node, self.executor, self.stop = node, executor, stop

    def wait_for_partners(self) -> None:
        """Wait until every topic has a subscriber, or no more come, or for as long as was asked."""
        begun = changed = time.monotonic()
        found = 0
        while not self.stop.asked and time.monotonic() - begun < self.node.given.wait:
            self.linger(0.05)
            partners = self.node.partners()
            if partners[0] != found:
                found, changed = partners[0], time.monotonic()
            if partners[1] or (found and time.monotonic() - changed > LAST_PARTNER):
                break
        self.linger(min(SETTLE, self.node.given.wait))

    def linger(self, seconds: float) -> None:
        """Serve callbacks for a while."""
        until = time.monotonic() + seconds
        while time.monotonic() < until and not self.stop.asked:
            self.executor.spin_once(timeout_sec=0.02)

    def play(self, messages: Iterator[tuple[int, str, bytes]]) -> None:
        """Publish all messages at their times."""
        node = self.node
        self.anchor: tuple[float, int] | None = None
        for at, topic, data in messages:
            while not self.stop.asked and not self.is_due(at):
                pass
            if self.stop.asked:
                return
            node.publish(topic, data, at)
            if node.count % BURST == 0:
                self.executor.spin_once(timeout_sec=0)

    def is_due(self, at: int) -> bool:
        """Whether a message of bag time ``at`` [ns] is due; serves callbacks for a moment where it is not."""
        if self.node.paused:
            self.anchor = None
            if self.node.steps.acquire(blocking=False):
                return True
            self.executor.spin_once(timeout_sec=0.02)
            return False
        if self.anchor is None:
            self.anchor = time.monotonic(), at
        wall, bag = self.anchor
        left = wall + (at - bag) / SECOND / self.node.given.rate - time.monotonic()
        if left > 0:
            self.executor.spin_once(timeout_sec=min(left, 0.05))
        return left <= 0


def renamed(pairs: list[str]) -> dict[str, str]:
    """Old and new topic names. Raises ArgumentError for what is not OLD:=NEW."""
    names = {}
    for pair in pairs:
        old, sign, new = pair.partition(":=")
        if not (old and sign and new):
            raise ArgumentError(f"--remap {pair}: give OLD:=NEW")
        try:
            validate_full_topic_name(full(new))
        except InvalidTopicNameException as error:
            raise ArgumentError(f"--remap {pair}: {str(error).splitlines()[0]}") from None
        names[full(old)] = full(new)
    return names


def full(topic: str) -> str:
    """A topic with its leading slash."""
    return topic if topic.startswith("/") else f"/{topic}"


def selected(given: argparse.Namespace, topics: list[Topic]) -> list[Topic]:
    """The topics to publish. Raises ArgumentError for one that the bag does not have."""
    there = {topic.name for topic in topics}
    only, without = {full(name) for name in given.topics}, {full(name) for name in given.exclude}
    for name in sorted((only | without | set(renamed(given.remap))) - there):
        raise ArgumentError(f"{given.bag} has no topic {name}: it has {', '.join(sorted(there))}")
    if given.clock:
        without.add(CLOCK)
    return [topic for topic in topics if topic.name not in without and (not only or topic.name in only)]


def main(argv: list[str]) -> int:
    """Replay a bag: 0 at its end or when asked to end, 2 (a TrunkError) for what cannot be played."""
    own, ros = split_ros(argv)
    given = parser().parse_args(own)
    if not 0 < given.rate < float("inf"):
        raise ArgumentError(f"--rate {given.rate:g}: give a number above 0")
    if given.clock is not None and not 0 < given.clock <= 10000:
        raise ArgumentError(f"--clock {given.clock:g}: give a rate above 0")
    if given.through:
        return compare(given, ros)
    with BagSource(given.bag, given.from_time, given.until) as bag:
        for note in bag.notes:
            print(f"{given.bag}: {note}", file=sys.stderr)
        topics = selected(given, bag.topics)
        stop = Stop()
        start_ros(ros)
        try:
            play(given, bag, topics, stop)
        finally:
            stop.ignore()
            rclpy.try_shutdown()
    return 0


def compare(given: argparse.Namespace, ros: list[str]) -> int:
    """The node and what was recorded of it, side by side."""
    start_ros(ros)
    try:
        from trunk_ros.nodes.bags.through import through  # it reads whole recordings, with scipy

        return through(given.bag, given.through, given.model, given.tolerance, given.namespace)
    finally:
        rclpy.try_shutdown()


def play(given: argparse.Namespace, bag: BagSource, topics: list[Topic], stop: Stop) -> None:
    """Publish until the end of the bag."""
    node = Replay()
    node.prepare(given, topics)
    start(node)
    executor = EventsExecutor()
    executor.add_node(node)
    if given.step:
        threading.Thread(target=read_steps, args=[node], daemon=True).start()
    player = Player(node, executor, stop)
    player.wait_for_partners()
    while not stop.asked:
        player.play(bag.messages(set(node.outlets)))
        if not given.loop or not node.count:
            break
    player.linger(SETTLE)
    end(node, DELIVERY)
    print(f"{given.bag}: {node.count} messages on {len(node.outlets)} topics")


def read_steps(node: Replay) -> None:
    """A step for each line on the standard input."""
    for _ in sys.stdin:
        node.steps.release()
