"""A diagnosis of the last minutes, in a process of its own that gives way to all others."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

YIELDING = 10  # niceness, that of nice(1): at 19 it does not come to an end beside other work
FOLDER = "diagnosis"


@dataclass
class SecondLook:
    """``bag`` is diagnosed against the model file ``model`` from ``since`` s on, into a folder beside it."""

    bag: Path
    model: Path
    since: float
    process: subprocess.Popen[str] | None = None

    @property
    def output(self) -> Path:
        """Folder of the diagnosis."""
        return self.bag.parent / FOLDER

    def start(self) -> None:
        """Start the process."""
        command = [
            sys.executable, "-m", "trunk_ros", "diagnose", str(self.bag), "--model", str(self.model),
            "--output", str(self.output), "--from-time", f"{max(self.since, 0.0):.3f}",
        ]  # fmt: skip
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
        self.process = subprocess.Popen(
            command, env=os.environ | threads, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, self.process.pid, YIELDING)

    @property
    def running(self) -> bool:
        """Whether it is under way."""
        return self.process is not None and self.process.poll() is None

    def stop(self) -> None:
        """End the process where it still runs."""
        if self.process is not None and self.process.poll() is None:
            self.process.terminate()
            self.process.wait()

    def result(self) -> tuple[list[dict[str, Any]], str]:
        """The findings, or why there are none."""
        assert self.process is not None
        error = self.process.stderr.read().strip() if self.process.stderr else ""
        if self.process.returncode:
            return [], error.splitlines()[-1] if error else f"diagnose ended with {self.process.returncode}"
        told = json.loads((self.output / "diagnosis.json").read_text())
        return told["findings"], "" if told["findings"] else f"verdict: {told['verdict'].replace('_', ' ')}"
