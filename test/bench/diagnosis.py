"""Diagnosis: processor time and memory of the command, five joints at 100 Hz and more; FULL=1 adds hours."""

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
from typing import Any

import numpy as np

from test.bench.row import Row
from test.concealed.bag import write_bag
from test.concealed.case import draw_case
from test.diagnosis.arms import on, recorded
from trunk_ros.recording.write import write_recording

HIDDEN: dict[str, dict[str, Any]] = {
    "backlash": {"half_width": on(2, 6e-4)},
    "ratio_error": {"relative": on(4, 0.005)},
    "wire_slip": {"step": on(5, 5e-4), "onset": np.full(5, 33.0)},
}
SIX = 64102
"""Seed of an arm with six effects at once."""
# Time and peak memory are those of the child alone: a process of its own runs the command and reports.
CHILD = """
import resource, sys
from trunk_ros.__main__ import main
code = main(sys.argv[1:])
own, theirs = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
print(sum(each.ru_utime + each.ru_stime for each in (own, theirs)), own.ru_maxrss / 1024, file=sys.stderr)
sys.exit(code)
"""


@dataclass(frozen=True)
class Run:
    """A recording of so many ``seconds`` at a ``rate`` [Hz], and the most that it should take: s of processor
    time, MiB.
    """

    seconds: float
    rate: float = 100.0
    time: float | None = None
    memory: float | None = None


RUNS = {"60 s": Run(60.0), "120 s": Run(120.0, time=10.0), "60 s at 1 kHz": Run(60.0, 1000.0, 15.0)}
LONG = {"1 h": Run(3600.0, time=60.0), "2 h": Run(7200.0, time=120.0, memory=600.0)}


def measure() -> Iterator[Row]:
    """The whole command, from reading to the report."""
    full = os.environ.get("FULL", "") not in ("", "0")
    for name, run in (RUNS | (LONG if full else {})).items():
        with tempfile.TemporaryDirectory() as folder:
            recording = recorded(HIDDEN, seconds=run.seconds, rate=run.rate)
            write_recording(Path(folder) / "run", recording)
            took, memory, _, found = diagnosed(Path(folder))
        yield Row(f"{name}: diagnose", took, "s", at_most=run.time)
        yield Row(f"{name}: peak memory", memory, "MiB", at_most=run.memory)
        yield Row(f"{name}: hidden effects that were named", len(found & set(HIDDEN)), f"of {len(HIDDEN)}")
    with tempfile.TemporaryDirectory() as folder:
        write_bag(draw_case(SIX, count=6).train, Path(folder) / "run", SIX)
        took, memory, alone, _ = diagnosed(Path(folder))
        _, _, both, _ = diagnosed(Path(folder), "--cores", "2", "--overwrite")
    yield Row("six effects at once: diagnose", took, "s", at_most=30.0)
    yield Row("six effects at once: peak memory", memory, "MiB")
    yield Row("six effects at once: on two cores", alone / both, "times as fast", at_least=2.0)


def diagnosed(folder: Path, *options: str) -> tuple[float, float, float, set[str]]:
    """Processor time [s], peak memory [MiB], time on the clock [s] and the effects that were found."""
    said = ["diagnose", str(folder / "run"), "--output", str(folder / "out"), *options]
    begin = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", CHILD, *said], capture_output=True, text=True, check=True)
    clock = time.perf_counter() - begin
    found = json.loads((folder / "out" / "diagnosis.json").read_text())["findings"]
    took, memory = map(float, done.stderr.split()[-2:])
    return took, memory, clock, {f["effect"] for f in found}
