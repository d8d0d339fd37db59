"""Fleet: how well the workers are used, the memory of a worker, and the scheduler's share of many tasks."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from test.bench.row import Row
from test.diagnosis.arms import on, recorded
from trunk_ros.fleet.inputs.listing import listed
from trunk_ros.fleet.run.cluster import connected, each
from trunk_ros.fleet.run.examine import examine
from trunk_ros.fleet.run.loop import Plan, run
from trunk_ros.fleet.run.store import Store
from trunk_ros.model import load_model
from trunk_ros.recording.write import write_recording

WORKERS = 2
FULL = os.environ.get("FULL", "") not in ("", "0")
BAGS, SECONDS = (1000, 60.0) if FULL else (12, 20.0)
TASKS = 100_000 if FULL else 5_000
ROOM = 1e6


def measure() -> Iterator[Row]:
    """Real recordings, then tasks that do nothing."""
    yield from workers()
    yield from scheduler()


def workers() -> Iterator[Row]:
    """Wall time over the tasks' CPU time per worker; memory of the workers at half-time and at the end."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write(folder / "bags" / "arm")
        jobs = listed([str(folder / "bags")])
        model, store = load_model("trunk"), Store(folder / "out", "recordings")
        plan = Plan(examine, lambda job: (job.path, model, False), lambda _: "bench")
        with connected(None, WORKERS) as client:
            list(each(client, examine, [(None, (jobs[0].path, model, False))] * WORKERS))  # imports, compiles
            begun, memory = time.perf_counter(), []

            def tick() -> None:
                memory.append(max(client.run(_resident).values()))

            run(client, jobs, plan, store, tick)
            wall = time.perf_counter() - begun
        store.close()
        cpu = sum(pq.read_table(folder / "out" / "recordings.parquet")["cpu"].to_pylist())
    yield Row(f"{len(jobs)} recordings of {SECONDS:g} s: wall time", wall, "s")
    yield Row("wall time over CPU time per worker", wall * WORKERS / cpu, "1", at_most=1.15)
    yield Row("memory of a worker at the end", memory[-1] / ROOM, "MB")
    yield Row(
        "memory of a worker, end over half-time", memory[-1] / memory[len(memory) // 2], "1", at_most=1.1
    )


def scheduler() -> Iterator[Row]:
    """A dry run: tasks that return at once."""
    with connected(None, WORKERS) as client:
        begun = time.perf_counter()
        done = sum(1 for _ in each(client, _nothing, ((k, (k,)) for k in range(TASKS))))
        took = time.perf_counter() - begun
    yield Row(f"dry run of {done} tasks, per task", took / done * 1e3, "ms", at_most=10.0)


def _write(folder: Path) -> None:
    for k in range(BAGS):
        hidden: dict[str, dict[str, Any]] = {"backlash": {"half_width": on(1 + k % 5, 5e-4)}}
        made = recorded(hidden, seconds=SECONDS, seed=k)
        write_recording(folder / f"run_{k:04d}", replace(made, start_ns=made.start_ns + k * 10**9))


def _resident() -> float:
    """Bytes that a worker holds."""
    return float(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _nothing(k: int) -> int:
    return k
