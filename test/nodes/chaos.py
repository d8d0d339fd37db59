"""``python -m test.nodes.chaos --seconds 600``: a live arm whose nodes are killed, stopped and lied to.

Four nodes, each in a process of its own, follow a reference. At random moments one is killed and started
anew, or stopped and continued; hostile and malformed messages come on all their topics; the reference falls
silent. Watched is that the gearbox never goes faster than the servo can, that only finite numbers are
published, that no node ends by itself, and that in the end every node works again or says why it does not.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from test.nodes import hostile
from test.nodes.domains import own_domain
from test.nodes.graph import (
    JOINTS,
    ROOT,
    Peer,
    environment,
    seconds,
)
from test.nodes.graph import words as said_by
from trunk_ros.model import load_model
from trunk_ros.recording.recover import recover

NODES = ("servo_driver", "wire_elasticity", "compensator", "recorder")
ANSWERS = {
    "servo_driver": "trunk/gearbox_states",
    "wire_elasticity": "joint_states",
    "compensator": "trunk/setpoints",
}
RATE, QUIET = 50.0, 15.0  # Hz of the reference; s of peace at the end in which all have to come back
PAUSE = (0.5, 3.0)  # s between two misfortunes
BURST = 40  # hostile messages at once
COUNT = 2 * np.pi / 131072  # rad that the encoder rounds by


class Watch:
    """What comes from the nodes: ``fastest`` of the gearbox over the servo's limit, what was wrong."""

    def __init__(self, peer: Peer):
        from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState, PoseStamped

        arm = load_model("trunk").arm
        self.limit, self.fastest, self.last = arm.v_max, 0.0, None
        self.wrong: list[str] = []
        self.heard: Counter[str] = Counter()
        self.said = peer.listen(DiagnosticArray, "diagnostics")
        for topic in (
            "trunk/reference",
            "trunk/setpoints",
            "trunk/gearbox_states",
            "joint_states",
            "trunk/wire_states",
        ):
            peer.node.create_subscription(JointState, topic, self._hear(topic), 200)
        peer.node.create_subscription(PoseStamped, "trunk/tip_pose", self._pose, 200)

    def _hear(self, topic: str) -> Callable[[Any], None]:
        def heard(message: Any) -> None:
            if message.header.frame_id == hostile.MARK:
                return
            self.heard[topic] += 1
            values = [*message.position, *message.velocity, *message.effort]
            if not np.isfinite(values).all():
                self._note(f"{topic} says {values} at {seconds(message.header.stamp):.3f}")
            if topic == ANSWERS["servo_driver"]:
                self._speed(message)

        return heard

    def _pose(self, message: Any) -> None:
        at, turn = message.pose.position, message.pose.orientation
        if not np.isfinite([at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w]).all():
            self._note("trunk/tip_pose is not finite")

    def _speed(self, message: Any) -> None:
        at, position = seconds(message.header.stamp), np.array(message.position)
        before, self.last = self.last, (at, position)
        if before is not None and at > before[0]:
            moved = np.maximum(np.abs(position - before[1]) - COUNT, 0.0)
            self.fastest = max(self.fastest, float(moved.max() / (at - before[0])) / self.limit)

    def _note(self, text: str) -> None:
        if len(self.wrong) < 20:
            self.wrong.append(text[:300])


class Arm:
    """The four processes, and what is done to them."""

    def __init__(self, domain: int, folder: Path, chance: random.Random):
        self.domain, self.folder, self.chance = domain, folder, chance
        self.running: dict[str, subprocess.Popen[bytes]] = {}
        self.done: Counter[str] = Counter()
        self.ended: list[str] = []
        self.bags: list[Path] = []
        for node in NODES:
            self.start(node)

    def start(self, node: str) -> None:
        """Begin a node anew; a recorder with a bag of its own."""
        command = [sys.executable, "-m", "trunk_ros", node]
        if node == "recorder":
            self.bags.append(self.folder / f"bag_{len(self.bags)}")
            command += ["--ros-args", "-p", f"output:={self.bags[-1]}"]
        log = (self.folder / f"{node}.log").open("ab")
        self.running[node] = subprocess.Popen(
            command, cwd=ROOT, env=environment(self.domain), stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
        log.close()

    def misfortune(self) -> tuple[float, Callable[[], None]]:
        """Kill or stop one of the nodes; how long that lasts, and how it ends."""
        node, kill = self.chance.choice(NODES), self.chance.random() < 0.5
        process = self.running[node]
        self.done["killed" if kill else "stopped"] += 1
        process.send_signal(signal.SIGKILL if kill else signal.SIGSTOP)
        if not kill:
            return self.chance.uniform(0.2, 3.0), lambda: process.send_signal(signal.SIGCONT)
        process.wait()
        return self.chance.uniform(0.2, 2.0), lambda: self.start(node)

    def look(self) -> None:
        """Note nodes that ended by themselves, and start them again."""
        for node, process in list(self.running.items()):
            if process.poll() not in (None, -signal.SIGKILL):
                said = self._last_words(node)
                self.ended.append(f"{node} ended with {process.returncode}: {said}")
                self.start(node)

    def close(self) -> None:
        """End all in good order."""
        for process in self.running.values():
            process.send_signal(signal.SIGCONT)
            process.send_signal(signal.SIGINT)
        for node, process in self.running.items():
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGABRT)  # says where it hangs
                process.wait()
                self.ended.append(f"{node} did not end when asked to: {self._last_words(node, 12)}")

    def _last_words(self, node: str, lines: int = 4) -> str:
        log = (self.folder / f"{node}.log").read_text(errors="replace").splitlines()
        return " | ".join(log[-lines:])[:1500]


class Foes:
    """The reference that the arm is to follow, and who disturbs it."""

    def __init__(self, peer: Peer, chance: random.Random):
        from trunk_ros.nodes.graph.ros import JointState, JointTrajectory

        self.peer, self.chance, self.sent = peer, chance, 0
        self.kind = JointState
        self.reference = peer.publisher(JointState, "trunk/reference")
        self.outlets = {
            topic: peer.publisher(JointTrajectory if topic.endswith("trajectory") else JointState, topic)
            for topic in hostile.TOPICS
        }

    def ask(self, at: float) -> None:
        """One point of a calm motion of all joints."""
        message = self.kind(name=list(JOINTS))
        message.header.stamp = self.peer.now()
        message.position = [0.2 * float(np.sin(0.7 * at + k)) for k in range(len(JOINTS))]
        self.reference.publish(message)

    def burst(self) -> None:
        """Many hostile messages on one topic, some of them no messages at all."""
        topic = self.chance.choice(hostile.TOPICS)
        for _ in range(self.chance.randint(1, BURST)):
            if self.chance.random() < 0.1:
                self.outlets[topic].publish(hostile.rubbish(self.chance))
            else:
                self.outlets[topic].publish(hostile.message(topic, self.chance, time.time_ns()))
            self.sent += 1


@contextmanager
def arm_on(folder: Path, seed: int) -> Iterator[tuple[Peer, Arm, Watch, Foes]]:
    """A live arm on a domain of its own, and the peer that watches and disturbs it."""
    with ExitStack() as left:
        domain = left.enter_context(own_domain())
        peer = left.enter_context(Peer(domain))
        arm = Arm(domain, folder, random.Random(seed))
        left.callback(arm.close)
        yield peer, arm, Watch(peer), Foes(peer, random.Random(seed + 1))


def suffer(peer: Peer, arm: Arm, watch: Watch, foes: Foes, length: float) -> None:
    """Let it all happen for so many s."""
    peer.until(lambda: all(watch.heard[topic] for topic in ANSWERS.values()) or foes.ask(0.0), 120.0)
    asked, next_one, silent = 0.0, 0.0, 0.0
    endings: list[tuple[float, Callable[[], None]]] = []
    begun = time.monotonic()
    while (at := time.monotonic() - begun) < length or endings:
        if at >= max(asked + 1 / RATE, silent):
            foes.ask(at)
            asked = at
        for ending in [each for each in endings if each[0] <= at]:
            endings.remove(ending)
            ending[1]()
            watch.last = None  # a simulated motor that is started anew stands at 0
        if at >= next_one and at < length:
            next_one = at + arm.chance.uniform(*PAUSE)
            which = arm.chance.random()
            if which < 0.4 and not endings:
                lasts, ending = arm.misfortune()
                endings.append((at + lasts, ending))
            elif which < 0.9:
                foes.burst()
            else:
                silent = at + arm.chance.uniform(0.5, 2.0)
                arm.done["reference lost"] += 1
        if not endings:
            arm.look()
        peer.spin_once()


def in_peace(peer: Peer, arm: Arm, watch: Watch, foes: Foes, length: float) -> dict[str, bool]:
    """Which nodes answer once nobody disturbs them: on their topics; the recorder on diagnostics."""
    watch.heard.clear()
    watch.said.clear()
    begun = time.monotonic()
    while (at := time.monotonic() - begun) < length:
        foes.ask(at)
        arm.look()
        wait = time.monotonic() + 1 / RATE
        while time.monotonic() < wait:
            peer.spin_once()
    return {node: bool(watch.heard[topic]) for node, topic in ANSWERS.items()} | {
        "recorder": any(status.name.endswith("recorder") for each in watch.said for status in each.status)
    }


def whole_bags(arm: Arm) -> list[str]:
    """What of the recorders' bags cannot be repaired and read."""
    from rosbags.rosbag2 import Reader

    broken = []
    for bag in filter(Path.exists, arm.bags):
        try:
            recover(bag)
            with Reader(bag) as reader:
                sum(1 for _ in reader.messages())
        except Exception as error:
            broken.append(f"{bag.name}: {error}")
    return broken


def run(length: float, seed: int, folder: Path, quiet: float = QUIET) -> dict[str, Any]:
    """The whole run, and what came of it."""
    with arm_on(folder, seed) as (peer, arm, watch, foes):
        suffer(peer, arm, watch, foes, length)
        back = in_peace(peer, arm, watch, foes, quiet)
        reasons = {node: said_by(watch.said, node)[-300:] for node, there in back.items() if not there}
    broken = whole_bags(arm)
    held = all(there or reasons[node].strip() for node, there in back.items())
    return {
        "seconds": length,
        "seed": seed,
        "done": dict(arm.done),
        "hostile_messages": foes.sent,
        "fastest_over_limit": watch.fastest,
        "not_finite": watch.wrong,
        "ended_by_themselves": arm.ended,
        "back": back,
        "reasons": reasons,
        "bags": len(arm.bags),
        "broken_bags": broken,
        "passed": bool(
            watch.fastest <= 1.0 + 1e-6 and not watch.wrong and not arm.ended and not broken and held
        ),
    }


def main(argv: list[str] | None = None) -> int:
    """0 where the arm came through, 1 where it did not; ``chaos.json`` says how."""
    parser = argparse.ArgumentParser(prog="python -m test.nodes.chaos", description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, help="a folder for chaos.json")
    asked = parser.parse_args(argv)
    folder = Path(tempfile.mkdtemp(prefix="trunk_ros_chaos_"))
    try:
        result = run(asked.seconds, asked.seed, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    text = json.dumps(result, indent=1)
    print(text)
    if asked.output:
        asked.output.mkdir(parents=True, exist_ok=True)
        (asked.output / "chaos.json").write_text(text + "\n")
    return 0 if result["passed"] else 1


if __name__ == "__main__":
    sys.exit(main())
