"""Diagnosis: time and memory of the command over the length, five joints at 100 Hz; FULL=1 adds an hour."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from test.bench.row import Row
from test.diagnosis.arms import on, recorded
from trunk_ros.recording.write import write_recording

LENGTHS = {"60 s": (60.0, None), "120 s": (120.0, 10.0)}
HOUR = {"1 h": (3600.0, 180.0)}
MEMORY = 2048.0  # MiB
HIDDEN: dict[str, dict[str, Any]] = {
    "backlash": {"half_width": on(2, 6e-4)},
    "ratio_error": {"relative": on(4, 0.005)},
    "wire_slip": {"step": on(5, 5e-4), "onset": np.full(5, 33.0)},
}
# Peak memory is that of the child alone: a process of its own runs the command and reports.
CHILD = """
import resource, sys
from trunk_ros.__main__ import main
code = main(sys.argv[1:])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, file=sys.stderr)
sys.exit(code)
"""


def measure() -> Iterator[Row]:
    """The whole command, from reading to the report."""
    full = os.environ.get("FULL", "") not in ("", "0")
    for name, (seconds, most) in (LENGTHS | (HOUR if full else {})).items():
        with tempfile.TemporaryDirectory() as folder:
            took, memory, named = diagnosed(Path(folder), seconds)
        yield Row(f"{name}: diagnose", took, "s", at_most=most)
        yield Row(f"{name}: peak memory", memory, "MiB", at_most=MEMORY)
        yield Row(f"{name}: hidden effects that were named", named, f"of {len(HIDDEN)}")


def diagnosed(folder: Path, seconds: float) -> tuple[float, float, int]:
    """Time [s], peak memory [MiB] and how many of the hidden effects were named."""
    write_recording(folder / "run", recorded(HIDDEN, seconds=seconds))
    command = [sys.executable, "-c", CHILD, "diagnose", str(folder / "run"), "--output", str(folder / "out")]
    begin = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    took = time.perf_counter() - begin
    found = json.loads((folder / "out" / "diagnosis.json").read_text())["findings"]
    return took, float(done.stderr.split()[-1]), len({f["effect"] for f in found} & set(HIDDEN))
