"""Nodes in processes of their own, that end in good order and never outlive who started them."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import yaml

SIGNAL_WHEN_PARENT_DIES = 1  # prctl's PR_SET_PDEATHSIG
GRACE = 10.0  # s to end in


class Processes:
    """One process per node."""

    def __init__(self, ros_arguments: list[str]):
        self.ros_arguments = ros_arguments
        self.folder = tempfile.TemporaryDirectory(prefix="trunk_ros_")
        self.running: dict[str, subprocess.Popen[bytes]] = {}
        self.code = 1
        """What to exit with where a process ended by itself: 2 where it said so of itself."""

    def start(self, part: str, parameters: dict[str, Any]) -> None:
        """Start a node with parameters, handed over in a file of its own."""
        file = Path(self.folder.name) / f"{part}.yaml"
        file.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
        ros = [*(self.ros_arguments or ["--ros-args"]), "--params-file", str(file)]
        command = [sys.executable, "-m", "trunk_ros", part, *ros]
        tied = partial(end_with, os.getpid())
        self.running[part] = subprocess.Popen(command, start_new_session=True, preexec_fn=tied)

    def ended(self) -> str:
        """Words about a node that ended by itself, "" where all run."""
        for part, process in self.running.items():
            code = process.poll()
            if code is not None:
                self.code = 2 if code == 2 else 1
                return (
                    f"{part} ended with exit code {code}"
                    if code >= 0
                    else f"{part} was ended by signal {-code}"
                )
        return ""

    def stop(self, parts: list[str]) -> None:
        """End nodes in good order; who does not end in time is killed."""
        stopping = [self.running.pop(part) for part in parts if part in self.running]
        for process in stopping:
            process.send_signal(signal.SIGINT)
        until = time.monotonic() + GRACE
        for process in stopping:
            try:
                process.wait(max(until - time.monotonic(), 0.1))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def close(self) -> None:
        """End all that is left."""
        self.stop(list(self.running))
        self.folder.cleanup()


def end_with(parent: int) -> None:
    """Ask the kernel to end this process when its parent dies, whose number may be 1 in a container."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(SIGNAL_WHEN_PARENT_DIES, signal.SIGTERM)
        if os.getppid() != parent:
            os._exit(1)
