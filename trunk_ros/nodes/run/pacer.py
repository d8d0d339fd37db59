"""What gives a run its time: waits for all nodes, sends the trajectory, steps the clock or waits."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any

from trunk_ros.arm import Arm
from trunk_ros.motion import begun_from
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.health import REFUSED, WARN
from trunk_ros.nodes.graph.loop import steady_clock
from trunk_ros.nodes.graph.messages import nanoseconds, time_message, trajectory_message
from trunk_ros.nodes.graph.progress import Ledger, Progress
from trunk_ros.nodes.graph.qos import DEPTH, LATCHED, RELIABLE, SENSED
from trunk_ros.nodes.graph.reader import if_readable
from trunk_ros.nodes.graph.report import PROGRESS_TOPIC
from trunk_ros.nodes.graph.ros import (
    Clock,
    DiagnosticArray,
    JointState,
    JointTrajectory,
    Node,
    String,
)
from trunk_ros.trajectory import Trajectory

BEGIN = 1_750_000_000 * SECOND  # ns, where simulated time begins, so that equal runs have equal stamps
CONNECT = 5.0  # s for all partners to be connected once everybody is there; some never match
SETTLED = 3  # looks in a row at which all partners are connected
START = 120.0  # s for our nodes to appear, on the slowest machine: one that ends is noticed at once
FIND = 30.0  # s for all to find each other, and what others publish
NEEDED = "trunk/gearbox_states"  # unseen, the arm would be sent from wherever it stands
PATIENCE = 30.0  # s for nodes to answer
SLOW = 2.0  # s without progress after which the clock is said again
LOST = 3.0  # s without progress after which messages under way are given up


@dataclass(frozen=True)
class Pace:
    """What a run is to do. ``foreign``: topics that others publish, waited for in each simulated step."""

    seconds: float
    rate: float
    simulated: bool
    trajectory: Trajectory | None
    foreign: tuple[str, ...] = ()
    description: str = ""
    arm: Arm | None = None
    """That moves, where it is another's: it may stand anywhere."""


class Pacer(Node):
    """Phases: ``gather``, ``announce``, ``run``, ``drain`` (simulated time), ``done``; ``fault``: why not,
    ``refused`` where that is no fault of ours.
    """

    def __init__(self, pace: Pace, ledger: Ledger, say: Callable[[str], None]):
        super().__init__("bringup")
        self.pace, self.ledger, self.say = pace, ledger, say
        self.phase, self.fault, self.refused = "gather", "", False
        self.step, self.steps = 0, round(pace.seconds * pace.rate)
        self.progress = Progress(self.get_fully_qualified_name(), stamp=2**63)
        self.moved = self.begun = time.monotonic()
        self.settled = 0
        self.complete = self.begun
        self.told: set[str] = set()
        self.stands: dict[str, float] = {}
        self.hear(DiagnosticArray, "diagnostics", self.pass_on)
        if pace.simulated:
            self.clock = self.create_publisher(Clock, "/clock", DEPTH)
            self.progress.sent["/clock"] = 0
        self.trajectory_topic = self.resolve_topic_name("trunk/joint_trajectory")
        if pace.trajectory is not None:
            self.send = self.create_publisher(JointTrajectory, "trunk/joint_trajectory", DEPTH)
            self.progress.sent[self.send.topic_name] = 0
            if pace.arm is not None:
                self.hear(JointState, "trunk/reference", self.note_posture)
        if pace.description:
            self.create_publisher(String, "robot_description", LATCHED).publish(String(data=pace.description))
        self.hear(String, PROGRESS_TOPIC, self.note_words)
        self.watched = [self.watch_foreign(topic) for topic in pace.foreign]
        self.create_timer(0.05, self.look, clock=steady_clock())
        ledger.note(self.progress)

    def watch_foreign(self, topic: str) -> str:
        """Keep an eye on a topic that no node of ours publishes."""
        name = self.resolve_topic_name(topic)

        def seen(message: Any) -> None:
            self.note(Progress(name, stamp=nanoseconds(message.header.stamp)))

        # as the nodes do: in real time a sensor that offers best effort is heard
        self.hear(JointState, topic, seen, RELIABLE if self.pace.simulated else SENSED)
        return name

    def hear(self, kind: Any, topic: str, callback: Callable[[Any], None], qos: Any = RELIABLE) -> None:
        """Subscribe to the messages of a topic that can be read."""
        self.create_subscription(kind, topic, if_readable(kind, callback), qos, raw=True)

    def note_words(self, message: Any) -> None:
        """A node in a process of its own says how far it is; what is no such message is not heard."""
        try:
            progress = Progress.from_json(message.data)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return
        self.note(progress)

    def note_posture(self, message: Any) -> None:
        """Where the compensator holds the arm until the motion begins."""
        if self.phase == "gather" and len(message.name) == len(message.position):
            self.stands = dict(zip(message.name, message.position, strict=True))

    def note(self, progress: Progress) -> None:
        """A node says how far it is."""
        self.ledger.note(progress)
        self.advance()

    def pass_on(self, message: Any) -> None:
        """Say what a node warns of, each thing once."""
        for status in message.status:
            words = f"{status.name.lstrip('/')}: {status.message}"
            if status.level[0] >= WARN and words not in self.told:
                self.told.add(words)
                self.say(words)
            if self.pace.trajectory is not None and status.name == self.own("compensator"):
                self.refuse(next((each.value for each in status.values if each.key == REFUSED), ""))

    def own(self, part: str) -> str:
        """The full name of a node of ours."""
        return str(self.get_namespace().rstrip("/") + "/" + part)

    def refuse(self, why: str) -> None:
        """End, as what was asked for cannot be done; goes on where nothing is said."""
        if why and not self.fault:
            self.fault, self.refused = why, True

    def advance(self) -> None:
        """Go on where everybody is ready for it."""
        if self.phase == "announce" and not any(
            way.startswith(self.trajectory_topic) for way in self.ledger.in_flight()
        ):
            self.enter("run")
            if self.pace.simulated:
                self.tell_time()
        elif self.phase == "run" and self.pace.simulated and self.ledger.complete(self.stamp):
            self.step += 1
            self.moved = time.monotonic()
            if self.step < self.steps:
                self.tell_time()
            else:
                self.enter("drain")

    @property
    def stamp(self) -> int:
        """The simulated time of the step under way [ns]."""
        return BEGIN + round(self.step * SECOND / self.pace.rate)

    def tell_time(self) -> None:
        """Publish the clock."""
        self.progress.sent["/clock"] += 1
        self.clock.publish(Clock(clock=time_message(self.stamp)))

    def enter(self, phase: str) -> None:
        """Begin a phase."""
        self.phase, self.moved, self.begun = phase, time.monotonic(), time.monotonic()

    def look(self) -> None:
        """What has to happen by the wall's clock."""
        silent = time.monotonic() - self.moved
        if self.phase == "gather":
            self.gather(silent)
        elif self.phase == "announce":
            self.advance()
            self.give_up_on_lost(silent)
        elif self.phase == "run" and self.pace.simulated:
            self.nudge(silent)
        elif self.is_over(silent):
            self.enter("done")

    def is_over(self, silent: float) -> bool:
        """Whether the time is up, and in simulated time everything recorded."""
        if self.phase == "drain":
            return silent > LOST or not self.ledger.in_flight(strict=True)
        return self.phase == "run" and silent >= self.pace.seconds

    def gather(self, silent: float) -> None:
        """Wait until all nodes are there and connected."""
        there = not self.ledger.missing() and not self.unrecorded() and not self.unheard()
        self.settled = self.settled + 1 if there and self.placed() and not self.loose() else 0
        if not there:
            self.complete = time.monotonic()
        ready = self.settled >= SETTLED or (there and time.monotonic() - self.complete > CONNECT)
        absent = self.unheard() if not self.ledger.missing() else ""
        if absent and silent > CONNECT and absent not in self.told:
            self.told.add(absent)
            self.say(f"waiting for somebody to publish {absent}{self.similar(absent)}")
        if not ready and silent < (START if self.ledger.missing() else FIND):
            return
        if self.ledger.missing():
            missing = ", ".join(name.lstrip("/") for name in self.ledger.missing())
            self.fault = f"not there after {START:.0f} s: {missing}"
            return
        if absent == self.resolve_topic_name(NEEDED) and self.pace.trajectory is not None:
            self.refuse(f"nobody publishes {absent}{self.similar(absent)}")
            return
        what = self.unheard() or self.unrecorded() or self.loose()
        if self.settled < SETTLED and what:  # by now they may have found each other
            self.say(f"beginning although {what} has not found all its partners")
        self.ledger.nodes += [topic for topic in self.watched if self.count_publishers(topic)]
        self.enter("announce")
        if self.pace.trajectory is not None:
            self.progress.sent[self.send.topic_name] += 1
            self.send.publish(trajectory_message(self.reached(self.pace.trajectory)))
        self.advance()

    def reached(self, motion: Trajectory) -> Trajectory:
        """The motion with the way to where it begins; the run is longer by it."""
        if self.pace.arm is None:
            return motion
        later = begun_from(motion, self.pace.arm, self.stands)
        if takes := float(later.time[0] - motion.time[0]):
            self.pace = replace(self.pace, seconds=self.pace.seconds + takes)
            self.say(f"the arm stands elsewhere than the motion begins: {takes:.1f} s more to get there")
        return later

    def placed(self) -> bool:
        """Whether it is known where another's arm stands, which a motion may have to begin from."""
        return self.pace.arm is None or self.pace.trajectory is None or bool(self.stands)

    def unheard(self) -> str:
        """A topic of others that nobody publishes yet."""
        return next((topic for topic in self.watched if not self.count_publishers(topic)), "")

    def similar(self, topic: str) -> str:
        """A topic with nearly the same name, in words."""
        others = [name for name, _ in self.get_topic_names_and_types() if name != topic]
        near = get_close_matches(topic, others, 1, 0.8)
        return f" (there is {near[0]})" if near else ""

    def loose(self) -> str:
        """A topic that lacks a partner, "" where there is none."""
        for progress in self.ledger.progress.values():
            for end, count in progress.matched.items():
                side, topic = end[0], end[1:]
                there = self.count_subscribers(topic) if side == ">" else self.count_publishers(topic)
                if count < there:
                    return topic
        return ""

    def unrecorded(self) -> str:
        """A topic of ours that the recorder has not found yet."""
        for recorder in self.ledger.lagging:
            known = self.ledger.progress[recorder].received
            for progress in self.ledger.progress.values():
                for topic in progress.sent:
                    if topic not in known:
                        return topic
        return ""

    def nudge(self, silent: float) -> None:
        """Say the time again where a step takes long, give up what was lost, and end where nobody answers."""
        if silent > PATIENCE:
            late = [name for name in self.ledger.nodes if self.stamp_of(name) < self.stamp]
            self.fault = f"no answer from {', '.join(late) or 'anybody'} for {PATIENCE:.0f} s"
        elif silent > SLOW and any(self.stamp_of(name) < self.stamp for name in self.ledger.nodes):
            foreign = [
                name
                for name in self.watched
                if name in self.ledger.nodes and self.stamp_of(name) < self.stamp
            ]
            if foreign and silent > LOST:
                self.say(f"{foreign[0]} does not keep up with the clock: not waited for any longer")
                self.ledger.nodes.remove(foreign[0])
                self.ledger.progress.pop(foreign[0], None)
                self.advance()
            else:
                self.clock.publish(Clock(clock=time_message(self.stamp)))
        else:
            self.give_up_on_lost(silent)

    def stamp_of(self, name: str) -> int:
        """How far a node is, -1 where it has not been heard of."""
        progress = self.ledger.progress.get(name)
        return -1 if progress is None else progress.stamp

    def give_up_on_lost(self, silent: float) -> None:
        """Go on without messages that do not arrive, and say so."""
        if silent > LOST:
            for way, count in self.ledger.excuse().items():
                self.say(f"lost {count} on {way}")
            self.advance()
