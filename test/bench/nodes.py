"""Nodes: rate, lateness, latency and cost of the whole graph over DDS, beside bare rclpy."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import Reader

from test.bench.row import Row
from test.nodes.graph import size_of
from trunk_ros.recording.bag.metadata import read_metadata

Array = NDArray[np.float64]
RATES = (100, 500, 1000)  # Hz
SECONDS = 8.0  # s that are measured of each run
WARM = 1.5  # s after the first data before they are
LAYOUTS = {"one process": [], "five processes": ["--processes"]}
TICK = os.sysconf("SC_CLK_TCK")  # 1/s, unit of /proc/PID/stat
STAMP = slice(4, 12)  # bytes of the stamp in a serialised message with a header


@dataclass(frozen=True)
class Run:
    """What a run of the graph cost and recorded.

    ``stamps`` and ``arrivals``: s, per topic; ``cpu``: share of one core while ``rate`` messages a second
    were published; ``lost``: messages.
    """

    cpu: float
    published: float
    lost: int
    stamps: dict[str, Array]
    arrivals: dict[str, Array]


def measure() -> Iterator[Row]:
    """All rates, in one process and in five."""
    for rate in RATES:
        bare = bare_rclpy(rate)
        per_message = bare["cpu"] / len(bare["sent"])
        yield from pace(f"{rate} Hz, bare rclpy", rate, np.array(bare["sent"]))
        yield from latency(f"{rate} Hz, bare rclpy: publisher to subscriber", np.array(bare["took"]))
        yield Row(f"{rate} Hz, bare rclpy: CPU", 100 * bare["cpu"] / bare["seconds"], "% of a core")
        yield Row(f"{rate} Hz, bare rclpy: CPU per message", 1e6 * per_message, "us")
        for layout, options in LAYOUTS.items():
            yield from graph(f"{rate} Hz, {layout}", rate, options, per_message)


def graph(name: str, rate: int, options: list[str], bare: float) -> Iterator[Row]:
    """One run of bringup; ``bare``: CPU [s] that bare rclpy takes per message.

    A message counts once, however many listen: a step of the arm is 6 messages that are delivered 11 times,
    the recorder's included, while bare rclpy delivers each of its messages once.
    """
    run = driven(rate, options)
    wanted = rate == 500 and not options
    yield from pace(name, rate, run.stamps["/trunk/gearbox_states"], wanted)
    yield from latency(f"{name}: setpoint to joint state", setpoint_to_joint(run))
    yield Row(f"{name}: messages lost", run.lost, "1", at_most=0 if wanted else None)
    yield Row(f"{name}: messages", run.published, "1/s")
    yield Row(f"{name}: CPU", 100 * run.cpu, "% of a core")
    ratio = run.cpu / run.published / bare
    yield Row(f"{name}: CPU per message over bare rclpy", ratio, "1", at_most=None if options else 1.5)


def pace(name: str, rate: int, stamps: Array, wanted: bool = False) -> Iterator[Row]:
    """Rate of a loop, and how late its steps come; ``wanted``: where there are targets."""
    between = np.diff(stamps)
    late = np.maximum(between - 1 / rate, 0.0)
    yield Row(f"{name}: loop rate", 1 / between.mean(), "Hz", at_least=0.99 * rate if wanted else None)
    yield Row(f"{name}: jitter", 1e3 * between.std(), "ms")
    most = 1e3 / rate if wanted else None
    yield Row(f"{name}: lateness, p99", 1e3 * float(np.quantile(late, 0.99)), "ms", at_most=most)


def latency(name: str, took: Array) -> Iterator[Row]:
    """Half of all, and all but one in a hundred, are faster."""
    for word, share in (("p50", 0.5), ("p99", 0.99)):
        yield Row(f"{name}, {word}", 1e3 * float(np.quantile(took, share)), "ms")


def setpoint_to_joint(run: Run) -> Array:
    """(n,) s from a setpoint's stamp to the arrival of the first joint state that can show it.

    The servo's loop reads the shafts at its own times, so up to a period of waiting is part of it.
    """
    asked, shown = run.stamps["/trunk/setpoints"], run.stamps["/joint_states"]
    first = np.searchsorted(shown, asked, side="right")
    there = first < len(shown)
    return run.arrivals["/joint_states"][first[there]] - asked[there]


def bare_rclpy(rate: int) -> dict[str, list[float] | float]:
    """Figures of a publisher and a subscriber, see bare.py."""
    command = [sys.executable, "-m", "test.bench.bare", str(rate), str(SECONDS)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def driven(rate: int, options: list[str]) -> Run:
    """Bring the graph up, measure it while it runs, and read what it recorded."""
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder, "run")
        seconds = SECONDS + WARM + 3.0
        command = [sys.executable, "-m", "trunk_ros", "bringup", "--output", str(bag)]
        command += ["--seconds", str(seconds), "--rate", str(rate), *options]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        wait_for_data(bag, process)
        begin, before = time.monotonic(), cpu_seconds(process.pid)
        time.sleep(SECONDS)
        cpu = (cpu_seconds(process.pid) - before) / (time.monotonic() - begin)
        _, error = process.communicate()
        if process.returncode:
            raise RuntimeError(error.decode())
        return recorded(bag, cpu)


def wait_for_data(bag: Path, process: subprocess.Popen[bytes]) -> None:
    """Until the graph has run for a while."""
    while not any(size_of(file) > 40_000 for file in bag.glob("*.mcap")):
        if process.poll() is not None:
            raise RuntimeError(str(process.communicate()[1], "utf-8"))
        time.sleep(0.05)
    time.sleep(WARM)


def cpu_seconds(number: int) -> float:
    """CPU time [s] that a process and its children have taken."""
    total = 0.0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if number in (int(stat.parent.name), int(fields[1])):
            total += (int(fields[11]) + int(fields[12])) / TICK
    return total


def recorded(bag: Path, cpu: float) -> Run:
    """Stamps and arrivals of a bag."""
    stamps: dict[str, list[float]] = {}
    arrivals: dict[str, list[float]] = {}
    with Reader(bag) as reader:
        for connection, arrival, data in reader.messages():
            seconds, nanoseconds = np.frombuffer(bytes(data[STAMP]), "<u4")
            stamps.setdefault(connection.topic, []).append(float(seconds) + nanoseconds * 1e-9)
            arrivals.setdefault(connection.topic, []).append(arrival * 1e-9)
        number = reader.message_count / (reader.duration * 1e-9)
    losses = json.loads(read_metadata(bag).custom["trunk_ros.loss"])
    lost = sum(int(each["lost"] + each["dropped"]) for each in losses.values())
    arrays = ({topic: np.array(each) for topic, each in by.items()} for by in (stamps, arrivals))
    return Run(cpu, number, lost, *arrays)
