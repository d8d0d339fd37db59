"""Kills recorders at random moments, repairs what they leave, and looks at what is lost:
`python -m test.recording.kill --times 100 --output kill.json`.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from test.nodes.domains import clean_shared_memory, segments
from trunk_ros.recording.read import read_recording

RECORDER = f"recorder_{os.getpid()}"  # nobody else's on the same domain
TOPIC = f"/{RECORDER}/joint_states"
ROOT = Path(__file__).resolve().parents[2]
PERIOD = 0.002  # s between two messages
LONGEST = 3.0  # s after its start, or after it has begun to hear, that a recorder is killed at the latest
EARLY, ENDING = 0.1, 0.2  # shares of the runs that are killed while they start, and while they end
MEET_AT_MOST = 60.0  # s; recorders that start late are waited for
ALLOWED = 1.0  # s that may be lost, of those in which the machine let the recorder work


@dataclass(frozen=True)
class Killed:
    """One run. ``lost_s``: how long before the kill the first missing message was sent, 0 for none."""

    moment: str
    seconds: float
    """From the start of the recorder to its end."""
    sent: int
    """While the recorder was there to hear it."""
    kept: int
    lost_s: float
    said: str


class Sender:
    """Numbers messages by their stamps; knows when each was sent."""

    def __init__(self) -> None:
        import numpy as np

        from trunk_ros.nodes.graph.messages import joint_state
        from trunk_ros.nodes.graph.ros import JointState, rclpy

        self.context = rclpy.Context()
        self.context.init()
        self.node = rclpy.create_node("sender", context=self.context)
        self.publisher = self.node.create_publisher(JointState, TOPIC, 1000)
        self.message = lambda ns: joint_state(ns, ["joint_1", "joint_2"], np.zeros(2))
        self.sent: dict[int, float] = {}

    def send(self, seconds: float = 0.0, heard: bool = False) -> None:
        """Send for a while, or until somebody hears; what nobody hears does not count."""
        end = time.monotonic() + (MEET_AT_MOST if heard else seconds)
        while (now := time.monotonic()) < end and not (heard and self.sent):
            stamp, counts = (
                time.time_ns(),
                bool(self.sent) or self.is_heard(),
            )  # before: none is sent to nobody
            self.publisher.publish(self.message(stamp))
            if counts:
                self.sent[stamp] = now
            time.sleep(PERIOD)
        assert self.sent or not heard, f"the recorder has not heard {TOPIC} for {MEET_AT_MOST:.0f} s"

    def is_heard(self) -> bool:
        """Whether our recorder, and not only somebody else's on the same domain, gets what is sent."""
        ears = self.node.get_subscriptions_info_by_topic(TOPIC)
        there = any(each.node_name == RECORDER for each in ears)
        return there and self.publisher.get_subscription_count() >= len(ears)

    def close(self) -> None:
        """Leave the graph."""
        self.node.destroy_node()
        self.context.try_shutdown()


@contextmanager
def recorder(bag: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A recorder in a process of its own."""
    given = ["-p", f"output:={bag}", "-p", f"topics:=['{TOPIC}']", "-r", f"__node:={RECORDER}"]
    command = [sys.executable, "-m", "trunk_ros", "recorder", "--ros-args", *given]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def kill_once(bag: Path, draw: random.Random) -> Killed:
    """Record, kill, repair, open with all readers. AssertionError where a promise is not kept."""
    sender, begun = Sender(), time.monotonic()
    moment = draw.choices(["start", "run", "end"], [EARLY, 1 - EARLY - ENDING, ENDING])[0]
    try:
        with recorder(bag) as process:
            if moment != "start":
                sender.send(heard=True)
            before = waited(process.pid)
            sender.send(draw.uniform(0.0, LONGEST))
            if moment == "end":
                process.send_signal(signal.SIGINT)
                time.sleep(draw.uniform(0.0, 0.3))
            late = max(waited(process.pid) - before, 0.0)  # threads that have ended count no more
            process.kill()
            killed = time.monotonic()
    finally:
        sender.close()
    said = repaired(bag)
    kept = stamps(bag) if said else set()
    gone = [at for stamp, at in sender.sent.items() if stamp not in kept]
    lost = killed - min(gone, default=killed)
    assert lost <= ALLOWED + late, f"{lost:.3f} s lost, {late:.3f} s waited for the machine: {said}"
    return Killed(moment, killed - begun, len(sender.sent), len(kept), lost, said)


def waited(number: int) -> float:
    """How long the threads of a process were ready to run but had no processor [s], where Linux counts it."""
    total = 0
    for each in Path(f"/proc/{number}/task").glob("*/schedstat"):
        with suppress(OSError):
            total += int(each.read_text().split()[1])
    return total * 1e-9


def repaired(bag: Path) -> str:
    """What `recover` says, "" where the recorder was killed before it had put anything into a file."""
    if not list(bag.glob("*.mcap")):
        return ""
    command = [sys.executable, "-m", "trunk_ros", "recover", str(bag)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode == 2 and "holds no whole message" in done.stderr:
        return ""
    assert done.returncode == 0, done.stderr
    return done.stdout.strip().replace(f"{bag}", "BAG")


def stamps(bag: Path) -> set[int]:
    """Stamps of the messages in a bag [ns], which every reader must find alike."""
    found = set()
    with AnyReader([bag]) as reader:
        wanted = [each for each in reader.connections if each.topic == TOPIC]
        for connection, _, data in reader.messages(wanted) if wanted else ():
            stamp: Any = reader.deserialize(data, connection.msgtype).header.stamp
            found.add(stamp.sec * 10**9 + stamp.nanosec)
        every = reader.message_count
    with Reader(bag) as reader:
        assert sum(1 for _ in reader.messages()) == every
    tools = 0
    for file in bag.glob("*.mcap"):
        with file.open("rb") as stream:
            tools += sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())
    assert tools == every
    if found:
        assert len(read_recording(bag).require("joint_states").stamp) == len(found)
    return found


def said(run: Killed) -> str:
    """One run in a line."""
    return f"at the {run.moment}: {run.sent} sent, {run.kept} kept, {run.lost_s:.3f} s lost; {run.said}"


def main(argv: list[str] | None = None) -> int:
    """Kill so many times; 0 where every bag could be repaired and at most the last second was lost."""
    asked = argparse.ArgumentParser(prog="python -m test.recording.kill", description=__doc__)
    asked.add_argument("--times", type=int, default=int(os.environ.get("KILLS", "100")))
    asked.add_argument("--seed", type=int, default=0)
    asked.add_argument("--output", type=Path, help="JSON file for the runs")
    given = asked.parse_args(argv)
    draw, runs = random.Random(given.seed), []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(given.times):
            before = {path.name for path in segments()}
            runs.append(kill_once(Path(folder) / f"bag_{number}", draw))
            clean_shared_memory(before)
            print(f"{number + 1}: {said(runs[-1])}", flush=True)
    worst = max(run.lost_s for run in runs)
    print(f"{len(runs)} recorders killed, every bag repaired; at most {worst:.3f} s lost")
    if given.output:
        report = {"schema": "trunk_ros/kill/1", "seed": given.seed, "times": len(runs), "worst_lost_s": worst}
        runs_told = [asdict(run) for run in runs]
        given.output.write_text(json.dumps(report | {"runs": runs_told}, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
