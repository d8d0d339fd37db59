"""Recording on one core in a process of its own, and reading; beside rosbags, and rosbag2 where installed."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from test.bench.row import Row
from test.recording import load, speed

SECONDS = 5.0
SMALL = (5000.0, 10_000.0, 15_000.0, 20_000.0)  # messages/s
LARGE = (25.0, 50.0, 100.0, 200.0)
MIB = 1 << 20
STARTING = 4.0  # s until a recorder hears
DOMAIN = "96"
TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Run:
    """What a recorder did with what was sent: processor s while it was sent, bytes on disk."""

    rate: float
    sent: int
    kept: int
    cpu: float
    size: int

    @property
    def lost(self) -> int:
        """Messages that are not in the bag."""
        return self.sent - self.kept


def measure() -> Iterator[Row]:
    """Recording of small and of large messages, then reading."""
    with tempfile.TemporaryDirectory() as folder:
        yield from recorded("trunk_ros", ours, Path(folder))
        if shutil.which("ros2"):
            yield from recorded("rosbag2", rosbag2, Path(folder))
        yield from rosbags_writer(Path(folder))
    yield from reading()


def ours(bag: Path) -> list[str]:
    """The command of our recorder."""
    return [sys.executable, "-m", "trunk_ros", "recorder", "--ros-args", "-p", f"output:={bag}"]


def rosbag2(bag: Path) -> list[str]:
    """The command of rosbag2, of which `ros2` is there, with the same compression."""
    return ["ros2", "bag", "record", "--storage-preset-profile", "zstd_fast", "-o", str(bag), "/load"]


def recorded(name: str, command: object, folder: Path) -> Iterator[Row]:
    """Rows of a recorder: loss and cost at each rate, and the highest without loss."""
    assert callable(command)
    own = name == "trunk_ros"
    small = [record(command, folder / f"{name}_{rate:.0f}", rate, 0) for rate in SMALL]
    for run in small:
        needed = 0 if own and run.rate == 10_000 else None
        yield Row(f"{name}, JointState at {run.rate:,.0f}/s: lost", run.lost, "messages", at_most=needed)
    yield Row(
        f"{name}, JointState, most without loss", most(small), "messages/s", at_least=1e4 if own else None
    )
    full = small[SMALL.index(10_000)]
    yield Row(f"{name}, JointState: processor", 1e6 * full.cpu / full.sent, "us/message")
    yield Row(f"{name}, JointState: on disk", full.size / max(full.kept, 1), "bytes/message")
    large = [record(command, folder / f"{name}_{rate:.0f}_large", rate, MIB) for rate in LARGE]
    for run in large:
        yield Row(f"{name}, 1 MiB at {run.rate:,.0f}/s: lost", run.lost, "messages")
    yield Row(f"{name}, 1 MiB, most without loss", most(large) * MIB / 1e6, "MB/s")
    full = large[1]
    yield Row(f"{name}, 1 MiB: processor", 1e6 * full.cpu / full.sent, "us/message")


def most(runs: list[Run]) -> float:
    """The highest rate without loss, 0 for none."""
    return max((run.rate for run in runs if not run.lost), default=0.0)


def record(command: object, bag: Path, rate: float, size: int) -> Run:
    """Record what another process sends, each on a core of its own."""
    assert callable(command)
    with process(command(bag), core=0) as recorder, process(loader(rate, size), core=-1) as sender:
        time.sleep(STARTING)
        before = cpu(recorder.pid)
        assert sender.stdout is not None
        sent = int(json.loads(sender.stdout.readline())["sent"])
        time.sleep(1.0)
        spent = cpu(recorder.pid) - before
        recorder.send_signal(signal.SIGINT)
        recorder.wait(60)
        sender.communicate()
    files = sum(each.stat().st_size for each in bag.iterdir())
    run = Run(rate, sent, kept(bag), spent, files)
    shutil.rmtree(bag)
    return run


def loader(rate: float, size: int) -> list[str]:
    """The command of the sender."""
    given = ["--rate", rate, "--seconds", SECONDS, "--size", size]
    return [sys.executable, "-m", "test.recording.load", *map(str, given)]


@contextmanager
def process(command: list[str], core: int) -> Iterator[subprocess.Popen[str]]:
    """A process on one core, ended with the block."""
    cores = sorted(os.sched_getaffinity(0))
    running = subprocess.Popen(
        command,
        env=os.environ | {"ROS_DOMAIN_ID": DOMAIN},
        text=True,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    os.sched_setaffinity(running.pid, {cores[core]})
    try:
        yield running
    finally:
        running.kill()
        running.communicate()


def cpu(pid: int) -> float:
    """Processor s of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def kept(bag: Path) -> int:
    """Messages of the load that a bag holds, counted one by one."""
    from rosbags.rosbag2 import Reader

    with Reader(bag) as reader:
        wanted = [each for each in reader.connections if each.topic == "/load"]
        return sum(1 for _ in reader.messages(wanted)) if wanted else 0


def rosbags_writer(folder: Path) -> Iterator[Row]:
    """The same small messages written by rosbags, from memory."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    from test.recording.bags import KIND, STORE

    bag, count, data = folder / "rosbags", 50_000, [bytes(each) for each in load.joint_states()]
    writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    begin = time.process_time()
    with writer:
        connection = writer.add_connection("/load", KIND, typestore=STORE)
        for number in range(count):
            writer.write(connection, number * 10**5, data[number % len(data)])
    spent = time.process_time() - begin
    size = sum(each.stat().st_size for each in bag.iterdir())
    yield Row("rosbags, JointState from memory: processor", 1e6 * spent / count, "us/message")
    yield Row("rosbags, JointState: on disk", size / count, "bytes/message")


def reading() -> Iterator[Row]:
    """An hour of four topics at 100 Hz into arrays."""
    seen = speed.measure()
    yield Row("reading one hour, 4 topics at 100 Hz", seen["read_s"], "s")
    yield Row("reading", seen["messages_per_s"], "messages/s")
    yield Row("rosbags, reading one hour", seen["rosbags_s"], "s")
    yield Row("reading over rosbags", seen["times_as_fast"], "1", at_least=5)
    with tempfile.TemporaryDirectory() as folder:
        for kind, (own, bytes_, alone) in speed.by_kind(Path(folder)).items():
            yield Row(f"reading {kind}", 1e6 * own, "us/message")
            yield Row(f"reading {kind}, bytes by rosbags and our decoder", 1e6 * bytes_, "us/message")
            yield Row(f"reading {kind}, rosbags alone", 1e6 * alone, "us/message")
    own, alone = speed.encoding()
    yield Row("encoding, five joints", 1e6 * own, "us/message")
    yield Row("rosbags, encoding, five joints", 1e6 * alone, "us/message")
