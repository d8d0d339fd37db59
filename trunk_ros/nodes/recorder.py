"""recorder: every topic of the run into an MCAP bag, byte for byte, with what was lost on the way."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from typing import Any

from trunk_ros.errors import TrunkError
from trunk_ros.nodes.bags.recorder_parameters import MIB, bag_options
from trunk_ros.nodes.bags.run_notes import WallClock, manifest
from trunk_ros.nodes.bags.writer import BagWriter, Channel, Entry
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.health import OK
from trunk_ros.nodes.graph.interfaces import message_class, message_definition
from trunk_ros.nodes.graph.losses import Tally, in_words
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.qos import hearing_all, latches, stricter, unique
from trunk_ros.nodes.graph.ros import LifecycleState, TransitionCallbackReturn
from trunk_ros.nodes.graph.topic_subscription import Ear, by_hand, subscribe
from trunk_ros.nodes.parameters import PARAMETERS

LOOK = 0.1  # s between two looks at the graph
TURNS = 20  # looks after which a topic's publishers are asked for their QoS again
TAKE = 0.01  # s between two looks for messages
AT_ONCE = 2000  # messages of one topic taken before the next topic has its turn
QUIET = 10  # empty looks after which everything has arrived
LAST = 1.0  # s after which no more is waited for
SHARED = ("/clock", "/tf", "/tf_static")  # topics that belong to every namespace


class Recorder(TrunkNode):
    """Takes messages from the middleware itself, not through the executor: faster, and with their numbers."""

    NAME = "recorder"
    idle = True
    recording = False
    ending = 0  # ns at which it was asked to end
    writer: BagWriter | None = None
    OWN = PARAMETERS[NAME]

    @property
    def subscriptions(self) -> Iterator[Any]:
        """Those that an executor serves."""
        return (each for each in super().subscriptions if each.callback is not by_hand)

    def configure(self) -> None:
        """Open the bag. Raises TrunkError where that is impossible."""
        options = bag_options(self)
        self.manifest = manifest(self)
        self.ears: dict[str, Ear] = {}
        self.looks = 0
        self.refused: dict[str, str] = {}
        self.early: list[Entry] = []
        self.early_bytes, self.room = 0, options.buffer_bytes
        self.wall = WallClock()
        self.ending = 0
        self.writer = BagWriter(self.value("output"), options, {"trunk_ros.manifest": self.manifest})
        self.wanted = {self.resolve_topic_name(topic) for topic in self.value("topics") if topic}
        self.others: dict[str, set[str]] = {}
        self.prefix = self.get_namespace().rstrip("/") + "/"
        self.unwanted = {self.resolve_topic_name(topic) for topic in self.value("exclude") if topic}
        self.unwanted.add(f"{self.get_fully_qualified_name()}/transition_event")  # of its own life
        for period, function in ((LOOK, self.look), (TAKE, self.take)):
            self.every(period, function)
        self.look()
        self.log(OK, f"recording into {self.value('output')}")

    # Finding topics

    def look(self) -> None:
        """Subscribe to topics that have appeared, and anew where a publisher's QoS asks for it."""
        self.looks += 1
        for number, (topic, _) in enumerate(self.get_topic_names_and_types(), self.looks):
            ear = self.ears.get(topic)
            if not self.is_wanted(topic) or topic in self.refused:
                continue
            if ear is not None and number % TURNS and ear.unchanged(self.count_publishers(topic)):
                continue  # to ask for QoS costs other nodes of the process their turn
            publishers = self.get_publishers_info_by_topic(topic)
            if not publishers:
                continue
            try:
                self.hear(topic, self.of_one_type(topic, publishers))
            except TrunkError as error:
                self.refused[topic] = f"{topic} is not recorded: {error}"
                self.health.note(self.refused[topic])

    def is_wanted(self, topic: str) -> bool:
        """Whether a topic is to be recorded; hidden ones and those of others only where they are named."""
        if self.wanted or topic in self.unwanted:
            return topic in self.wanted - self.unwanted
        own = self.value("all_namespaces") or topic in SHARED or topic.startswith(self.prefix)
        return own and not any(part.startswith("_") for part in topic.split("/"))

    def of_one_type(self, topic: str, publishers: list[Any]) -> list[Any]:
        """The publishers of the type that is recorded: of most of them, where it is not settled yet."""
        types = sorted(each.topic_type for each in publishers)
        ear = self.ears.get(topic)
        kind = ear.channel.type if ear else max(types, key=types.count)
        others = sorted(set(types) - {kind})
        if others:
            self.others.setdefault(topic, set()).update(others)
            said = f"{topic} is recorded as {kind}, not as {', '.join(others)}: a topic has one type"
            self.health.trouble(topic, said)
        return [each for each in publishers if each.topic_type == kind]

    def hear(self, topic: str, publishers: list[Any]) -> None:
        """Listen with a profile that all publishers match. Raises TrunkError for a type not installed."""
        if not publishers:
            return
        profile, kind = self.profile_for(publishers), publishers[0].topic_type
        ear = self.ears.get(topic)
        if ear is None:
            ear = self.new_ear(topic, kind, profile, publishers)
        elif stricter(ear.profile, profile):
            ear.settle(self.destroy_subscription, at_once=True)
            ear.beside(ear.subscription)
            ear.subscription, ear.profile = subscribe(self, topic, kind, profile), profile
        ear.settle(self.destroy_subscription)
        ear.tally.publishers = len(publishers)
        ear.channel.qos = unique(publishers)

    def new_ear(self, topic: str, kind: str, profile: Any, publishers: list[Any]) -> Ear:
        """Begin to listen; where only some publishers latch, for a while also to what they have latched."""
        text, known_hash = message_definition(kind)
        offered = str(publishers[0].topic_type_hash)
        digest = offered if offered.startswith("RIHS") else known_hash
        channel = Channel(topic, kind, text, digest, unique(publishers))
        tally = Tally(paused=not self.recording)
        ear = Ear(message_class(kind), subscribe(self, topic, kind, profile), profile, channel, tally)
        latched = [each for each in publishers if latches(each.qos_profile)]
        if latched and len(latched) < len(publishers):
            ear.beside(subscribe(self, topic, kind, self.profile_for(latched)))
        assert self.writer is not None
        self.writer.add_channel(channel)
        self.ears[topic] = ear
        self.streams.progress.received.setdefault(topic, 0)
        return ear

    def profile_for(self, publishers: list[Any]) -> Any:
        """The strictest profile that these publishers match."""
        return hearing_all([each.qos_profile for each in publishers], int(self.value("depth")))

    # Taking messages

    def tick(self, now: int) -> None:
        """Keep up with simulated time."""
        if self.simulated:
            self.take()

    def take(self) -> int:
        """Take what has arrived; returns how many messages."""
        if jump := self.wall.look():
            self.health.note(jump)
        total = 0
        for topic, ear in self.ears.items():
            for taken in ear.take(AT_ONCE):
                total += self.keep(topic, ear, *taken)
        if self.writer is not None and self.writer.failure and not self.fault:
            self.fault = self.health.fault = self.writer.failure
        return total

    def keep(self, topic: str, ear: Ear, data: bytes, info: dict[str, Any]) -> bool:
        """Count a message and queue it for the disk; False for one that was sent after the end."""
        number, arrival = info["publication_sequence_number"], info["received_timestamp"]
        if self.ending and info["source_timestamp"] > self.ending:
            return False
        self.streams.progress.received[topic] += 1
        if not ear.tally.goes_on(number):  # maybe of a publisher that has come since the last look
            ear.tally.publishers = max(ear.tally.publishers, self.count_publishers(topic))
        missing = ear.tally.note(number, self.now() if self.simulated else self.wall.steady(arrival))
        if missing:
            self.health.note(f"{missing} messages of {topic} lost")
        if self.recording:
            self.file(ear, arrival, info["source_timestamp"], number or 0, data)
        return True

    def file(self, ear: Ear, arrival: int, sent: int, number: int, data: bytes) -> None:
        """Hand a message to the writer. In simulated time what comes before the clock begins waits for it."""
        assert self.writer is not None
        at, source = (self.now(), self.now()) if self.simulated else (arrival, sent)
        entry = Entry(ear.channel, at, source, number, data)
        if at < 0:
            self.await_clock(ear, entry)
            return
        if self.early:
            self.file_early()
        if not self.writer.put(entry):
            ear.tally.dropped += 1
            if not self.writer.failure:  # else it has ended, and says why
                self.health.note(f"no room for messages of {ear.channel.name}: the disk is too slow")

    def await_clock(self, ear: Ear, entry: Entry) -> None:
        """Keep a message until the clock begins, as far as there is room."""
        if self.early_bytes + len(entry.data) > self.room:
            ear.tally.dropped += 1
            self.health.note(f"no room for messages of {ear.channel.name}: no /clock yet")
            return
        self.early_bytes += len(entry.data)
        self.early.append(entry)

    def file_early(self) -> None:
        """File what waited for the clock, at the time that it shows now."""
        now = max(self.now(), 0)
        for entry in self.early:
            assert self.writer is not None
            self.writer.put(entry._replace(log_ns=now, publish_ns=now))
        self.early.clear()
        self.early_bytes = 0

    # Saying and ending

    def diagnosing(self) -> None:
        """Say what was lost, and what waits."""
        tallies, values = [ear.tally for ear in self.ears.values()], self.health.values
        values["lost"] = str(sum(tally.lost for tally in tallies))
        values["dropped"] = str(sum(tally.dropped for tally in tallies))
        if not self.simulated:
            values["messages"] = str(sum(tally.received for tally in tallies))
            values["waiting [MiB]"] = f"{self.writer.queued_bytes / MIB:.2f}" if self.writer else "0"

    def beat(self) -> None:
        """Say as well which publishers have been found."""
        super().beat()
        for topic, ear in self.ears.items():
            self.streams.progress.matched["<" + topic] = ear.subscription.get_publisher_count()

    # Life cycle

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to record."""
        self.recording = True
        for ear in self.ears.values():
            ear.tally.resume()
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Pause, with all that has arrived so far."""
        self.take()
        self.recording = False
        for ear in self.ears.values():
            ear.tally.pause()
        return super().on_deactivate(state)

    def last_call(self) -> None:
        """What is sent from now on is not recorded."""
        self.ending = time.time_ns()

    def release(self) -> None:
        """Take what is still on its way, and end the bag. Sums up, where no bringup does."""
        writer = self.writer
        if writer is None:
            return
        self.ending = self.ending or time.time_ns()
        self.take_the_last()
        self.file_early()
        self.writer = None
        for ear in self.ears.values():
            ear.settle(self.destroy_subscription, at_once=True)
            self.destroy_subscription(ear.subscription)
        writer.close(self.noted)
        self.fault = self.fault or writer.failure
        if self.report.listener is None:
            print("\n".join(in_words(self.value("output"), self.losses())), flush=True)

    def take_the_last(self) -> None:
        """Take until nothing comes any more that was sent before the end."""
        quiet, begun = 0, time.monotonic()
        while quiet < QUIET and not self.fault and time.monotonic() - begun < LAST:
            quiet = 0 if self.take() else quiet + 1
            time.sleep(TAKE)

    def noted(self) -> dict[str, str]:
        """What the bag says of its making."""
        for ear in self.ears.values():
            ear.tally.dropped = ear.tally.received - ear.channel.count
        notes = [*self.wall.jumps, *self.refused.values()]
        said = {"trunk_ros.loss": json.dumps(self.losses()), "trunk_ros.manifest": self.manifest}
        return said | ({"trunk_ros.notes": json.dumps(notes)} if notes else {})

    def losses(self) -> dict[str, Any]:
        """Per topic: messages expected, received, lost, and the longest gap."""
        for topic, types in self.others.items():
            if topic in self.ears:
                self.ears[topic].tally.unrecorded = sorted(types)
        return {topic: ear.tally.summary() for topic, ear in sorted(self.ears.items())}


def main(argv: list[str]) -> int:
    """Record until asked to end."""
    return run_node(Recorder, argv)
