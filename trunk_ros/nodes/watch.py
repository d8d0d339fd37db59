"""watch: a running arm against its model; says what leaves its usual range, and diagnoses it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.errors import TrunkError
from trunk_ros.fleet.watch.monitor import LOOK, Change, Monitor
from trunk_ros.fleet.watch.second_look import SecondLook
from trunk_ros.model import Model, save_model
from trunk_ros.nodes.bags.last_minutes import LastMinutes
from trunk_ros.nodes.graph.base import TrunkNode
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.health import OK, WARN
from trunk_ros.nodes.graph.joint_state_reader import JointStateReader
from trunk_ros.nodes.graph.joints import JointMatcher
from trunk_ros.nodes.graph.messages import nanoseconds, time_message
from trunk_ros.nodes.graph.process import run_node
from trunk_ros.nodes.graph.ros import DiagnosticArray, DiagnosticStatus, JointState, KeyValue, PoseStamped
from trunk_ros.nodes.parameters import PARAMETERS
from trunk_ros.units import as_read

STATES = ("trunk/setpoints", "trunk/gearbox_states", "joint_states")
KEPT = ("trunk/reference",)  # for the bag alone
TIP = "trunk/tip_pose"
JUMP = SECOND  # ns back that mean another clock and no late message


@dataclass
class Episode:
    """A change that is being looked into: the bag is written at ``due`` ns."""

    change: Change
    due: int
    folder: Path
    look: SecondLook | None = None


class Watch(TrunkNode):
    """Listens only: nothing that it does or fails to do reaches the arm."""

    NAME = "watch"
    idle = True
    OWN = PARAMETERS[NAME]

    def configure(self) -> None:
        """Create the monitor and the streams."""
        self.begin(self.model)
        warm = np.zeros((2, len(self.model.arm.joints)))
        for stage in (self.monitor.wire.stage, self.monitor.servo.stage):
            stage.chain.run(warm, np.arange(2.0) / 100)  # compiles, so that no sample waits
        self.origin = self.newest = self.looked = self.heard = -1
        self.changes = 0
        self.episode: Episode | None = None
        self.last = LastMinutes(self.value("before") + self.value("after"))
        self.publish_changes = self.streams.publish(DiagnosticArray, "trunk/changes")
        for topic, name in zip(STATES, ("setpoints", "gearbox", "joint_states"), strict=True):
            self.hear(topic, self.taker(topic, name), "sensor_msgs/msg/JointState", JointState)
        for topic in KEPT:
            self.hear(topic, None, "sensor_msgs/msg/JointState", JointState)
        self.hear(TIP, None, "geometry_msgs/msg/PoseStamped", PoseStamped)
        self.alone: list[str] = []
        self.every(self.value("timeout"), self.look_for_publishers)

    def look_for_publishers(self) -> None:
        """Say of which topics nobody is a publisher, each time that changes: nothing is seen of those."""
        alone = [topic for topic in map(self.resolve_topic_name, STATES) if not self.count_publishers(topic)]
        if self.active and alone != self.alone:
            self.alone = alone
            if alone:
                self.log(
                    WARN, f"no publisher of {', '.join(alone)}: watched is what goes on between two of them"
                )

    def begin(self, model: Model) -> None:
        """What is usual for an arm of this model is learnt."""
        self.monitor = Monitor(model, self.value("false_alarms"))

    def use(self, model: Model) -> None:
        """Another model: what is usual is learnt anew."""
        self.say_what_is_due()
        super().use(model)
        self.begin(model)

    def hear(self, topic: str, take: Callable[[bytes], None] | None, name: str, kind: Any) -> None:
        """Keep a topic's messages for the bag, and take those that are watched."""
        full = self.resolve_topic_name(topic)
        self.last.add_topic(full, name)

        def arrived(data: bytes) -> None:
            self.last.add(full, self.now(), bytes(data))
            if take is not None:
                take(data)

        self.streams.sense(topic, arrived, kind, raw=True)

    def taker(self, topic: str, name: str) -> Callable[[bytes], None]:
        """A function that hands a serialised JointState to the monitor's input of a name."""
        read, matcher = JointStateReader().read, JointMatcher(self.model.arm.joints)
        stream = self.streams.watch(topic, self.value("timeout"))

        def taken(data: bytes) -> None:
            message = read(data)
            stamp = nanoseconds(message.header.stamp)
            self.streams.heard(stream, stamp)
            self.heard = self.now()
            values = matcher.gather(message.name, message.position)
            if matcher.unknown or matcher.missing:
                for oddity in matcher.oddities():
                    self.health.note(oddity)
            getattr(self.monitor, name)(self.seconds(topic, stamp), values)
            self.look(stamp)

        return taken

    def seconds(self, topic: str, stamp: int) -> float:
        """A topic's stamp [ns] as the monitor counts [s]; where time jumps back it begins anew."""
        if self.origin < 0:
            self.origin = stamp
        if self.newest >= 0 and self.newest - stamp > JUMP:
            self.health.note(f"{topic}: the stamps jumped back")
            self.monitor.restart()
            self.newest = self.looked = -1
        self.newest = max(self.newest, stamp)
        return (stamp - self.origin) / SECOND

    def look(self, stamp: int) -> None:
        """Every half second of samples, see what they show."""
        if 0 <= stamp - self.looked < LOOK * SECOND:
            return
        self.looked = stamp
        for change in self.monitor.look():
            self.on_change(change, stamp)

    def on_change(self, change: Change, stamp: int) -> None:
        """Say it, and begin to look into it; changes of the minutes after are in the same bag."""
        self.changes += 1
        self.health.note(change.statement)
        self.say(stamp, WARN, f"{change.stage}/{change.joint}", change.statement, told(change, self.origin))
        if self.episode is None and self.value("output"):
            name = datetime.fromtimestamp(stamp / SECOND, UTC).strftime("%Y%m%dT%H%M%S")
            folder = Path(self.value("output")) / f"{name}_{change.stage}_{change.joint}"
            self.episode = Episode(change, self.now() + round(self.value("after") * SECOND), folder)

    def tick(self, now: int) -> None:
        """Go on with what is being looked into."""
        if now - self.heard > self.value("timeout") * SECOND:
            self.say_what_is_due()
        episode = self.episode
        if episode is None:
            return
        if episode.look is None:
            if now >= episode.due:
                self.begin_diagnosis(episode)
        elif not episode.look.running:
            self.episode = None
            self.tell_findings(episode.look, episode.change)

    def say_what_is_due(self) -> None:
        """Say what has left its usual range where no more samples come that could tell what it looks like."""
        for change in self.monitor.settle():
            self.on_change(change, self.newest)

    def begin_diagnosis(self, episode: Episode) -> None:
        """Write the bag of before and after, and start the process that diagnoses what is after."""
        bag, model = episode.folder / "bag", episode.folder / "model.yaml"
        try:
            self.last.write(bag, {"trunk_ros.change": json.dumps(episode.change.__dict__)})
            save_model(self.model, model)
        except (TrunkError, OSError) as error:
            self.health.note(f"no bag of the change: {error}")
            self.episode = None
            return
        since = episode.change.since - (self.last.first - self.origin) / SECOND
        episode.look = SecondLook(bag, model, since)
        episode.look.start()

    def tell_findings(self, look: SecondLook, change: Change) -> None:
        """Publish what the diagnosis says."""
        findings, why = look.result()
        place = {"bag": str(look.bag), "report": str(look.output / "report.html")}
        if not findings:
            words = f"{change.stage}, {change.joint}: no finding ({why})"
            self.say(self.now(), OK, f"{change.stage}/{change.joint}", words, place | {"kind": "finding"})
            self.log(WARN, words)
        for found in findings:
            values = {
                "kind": "finding", "stage": found["stage"], "joints": ", ".join(found["joints"]),
                "effect": found["effect"], "regime": found["regime"],
                "confidence": f"{found['confidence']:.2f}", "parameters": json.dumps(found["parameters"]),
            }  # fmt: skip
            name = f"{found['stage']}/{'+'.join(found['joints']) or 'arm'}"
            self.say(self.now(), WARN, name, found["statement"], values | place)
        if findings:
            self.log(WARN, f"{in_a_line(findings)}; {place['report']}")

    def say(self, now: int, level: int, name: str, words: str, values: dict[str, str]) -> None:
        """One message on ``trunk/changes``."""
        status = DiagnosticStatus(level=bytes([level]), name=name, message=words, hardware_id="trunk")
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = time_message(max(now, 0))
        self.publish_changes(message)

    def diagnosing(self) -> None:
        """How much of what is usual is known."""
        for stage, share in self.monitor.learnt.items():
            self.health.values[f"{stage}: usual range known"] = f"{share:.0%}"
        self.health.values["changes"] = str(self.changes)
        self.health.values["no publisher"] = ", ".join(self.alone) or "none missing"

    def release(self) -> None:
        """End a diagnosis that is under way."""
        episode, self.episode = getattr(self, "episode", None), None
        if episode is not None and episode.look is not None:
            episode.look.stop()


def in_a_line(findings: list[dict[str, Any]]) -> str:
    """Each effect with its joints' values."""
    said = []
    for found in findings:
        held = found["parameters"].items()
        values = [f"{owner} {name} {as_read(v)}" for owner, named in held for name, v in named.items()]
        where = ", ".join(values) or ", ".join(found["joints"])
        said.append(f"{found['effect']} ({found['confidence']:.0%}): {where}")
    return "; ".join(said)


def told(change: Change, origin: int) -> dict[str, str]:
    """A change as the values of a message."""
    return {
        "kind": "change", "stage": change.stage, "joint": change.joint, "regime": change.regime,
        "or": ", ".join(change.rivals), "size": f"{change.size:.6g}", "unit": change.unit,
        "noise": f"{change.noise:.6g}",
        "since": f"{origin / SECOND + change.since:.3f}", "log evidence": f"{change.evidence:.1f}",
    }  # fmt: skip


def main(argv: list[str]) -> int:
    """Run the node until it is asked to end."""
    return run_node(Watch, argv)
