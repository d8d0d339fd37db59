"""Watch: what the monitor of five joints costs at 100 Hz, and its memory over simulated time."""

from __future__ import annotations

import os
import time
import tracemalloc
from collections.abc import Iterator

import numpy as np

from test.bench.row import Row
from test.diagnosis.arms import recorded
from trunk_ros.fleet.watch.monitor import Monitor
from trunk_ros.model import load_model

FULL = os.environ.get("FULL", "") not in ("", "0")
HOURS = 24.0 if FULL else 0.25
MINUTE = 60.0


def measure() -> Iterator[Row]:
    """CPU and memory while the same minute of motion comes again and again."""
    minute, monitor = recorded({}, seconds=MINUTE, seed=1), Monitor(load_model("trunk"))
    play(monitor, minute, 0.0)
    tracemalloc.start()
    play(monitor, minute, 61.0)
    before = tracemalloc.get_traced_memory()[0]
    count = max(int(HOURS * 60), 2)
    for k in range(2, count):
        play(monitor, minute, 61.0 * k)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    spent = []
    for k in range(count, count + 3):
        begun = time.process_time()
        play(monitor, minute, 61.0 * k)
        spent.append((time.process_time() - begun) / MINUTE)
    yield Row("one core, five joints at 100 Hz, without the messages", float(np.min(spent)), "1", at_most=0.1)
    yield Row(f"memory grown in {HOURS:g} h of motion", grown / 1e6, "MB", at_most=1.0)


def play(monitor: Monitor, minute: object, start: float) -> None:
    """One recording into the monitor."""
    series = minute.series  # type: ignore[attr-defined]
    stamps = (start + series["joint_states"].stamp).tolist()
    rows = [series[key].position for key in ("setpoints", "gearbox_states", "joint_states")]
    for k, at in enumerate(stamps):
        monitor.setpoints(at, rows[0][k])
        monitor.gearbox(at, rows[1][k])
        monitor.joint_states(at, rows[2][k])
        if k % 50 == 0:
            monitor.look()
