"""The processes of the demo: the real nodes and commands, and the concealed arm beside them."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from test.concealed.nominal import JOINTS, RATIO, V_MAX, Array
from test.concealed.removed import SKIP, read_angles
from test.concealed.trajectory import draw_reference
from test.nodes.domains import lock_domain

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 15.0  # s for a process to end in good order
TRIES, HEARD = 3, 0.9  # runs, and of its time what an arm has to have heard
APART = 0.2  # s between the points of a trajectory file
TOP_SPEED = 0.8 * RATIO * V_MAX


class DemoError(Exception):
    """A step of the demo failed; one line."""


@dataclass(frozen=True)
class Arm:
    """Which concealed arm: all that its process is told."""

    seed: int
    effects: str = ""

    def command(self, noise_seed: int, truth: Path) -> list[str]:
        """Arguments of its process."""
        asked = ["--effects", self.effects] if self.effects else []
        own = ["--seed", str(self.seed), "--noise-seed", str(noise_seed), "--truth", str(truth), *asked]
        return ["test.concealed.live", *own]


@cache
def domain() -> str:
    """A ROS_DOMAIN_ID that no other demo and no test on this machine uses while this process lives."""
    return str(lock_domain()[0])


def environment() -> dict[str, str]:
    """This host only, and a domain of the demo's own."""
    own = {"ROS_DOMAIN_ID": domain(), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return {**os.environ, **own, "PYTHONWARNINGS": "ignore"}


@contextmanager
def running(command: Sequence[str]) -> Iterator[subprocess.Popen[str]]:
    """A module as a process, ended with the block: asked first, killed where it does not listen."""
    process = subprocess.Popen(
        [sys.executable, "-m", *command], cwd=ROOT, env=environment(), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        yield process
    finally:
        end(process)


def end(process: subprocess.Popen[str]) -> None:
    """End a process in good order where it still runs."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def trunk(*arguments: Any) -> str:
    """A command of trunk_ros to its end; what it prints. What it warns of is passed on. Raises DemoError with
    its last words.
    """
    with running(["trunk_ros", *map(str, arguments)]) as process:
        out, error = process.communicate()
    if process.returncode:
        last = (error.strip().splitlines() or ["no word"])[-1]
        raise DemoError(f"{arguments[0]} ended with {process.returncode}: {last}")
    if warned := "\n".join(line for line in error.splitlines() if line.startswith(f"{arguments[0]}: ")):
        print(warned, file=sys.stderr)
    return out


def drive(arm: Arm, bag: Path, seconds: float, noise_seed: int, *motion: Any) -> str:
    """Compensator and recorder drive the concealed arm in simulated time; the recorder's summary.

    A run in which a busy machine let the arm hear a part of it only says nothing, and is made again.
    """
    truth = bag.with_name(f"{bag.name}_truth.npz")
    for _ in range(TRIES):
        said = _driven(arm, bag, truth, seconds, noise_seed, *motion)
        if np.ptp(np.load(truth)["stamp"]) > HEARD * seconds * 1e9:
            return said
        shutil.rmtree(bag)
    raise DemoError(f"the concealed arm heard only a part of {TRIES} runs")


def _driven(arm: Arm, bag: Path, truth: Path, seconds: float, noise_seed: int, *motion: Any) -> str:
    with running(arm.command(noise_seed, truth)) as plant:
        without = ("--without", "servo_driver", "wire_elasticity")
        said = trunk("bringup", "--output", bag, "--seconds", seconds, "--sim-time", *motion, *without)
        if plant.poll() is not None:
            error = plant.communicate()[1].strip().splitlines() or ["no word"]
            raise DemoError(f"the concealed arm ended: {error[-1]}")
    return said


def followed(bag: Path) -> tuple[Array, Array]:
    """Reference and true joint angle (n, 5) rad at the same stamps of a run of `drive`, once it has
    settled.
    """
    wanted = read_angles(bag, "trunk/reference")
    truth = np.load(bag.with_name(f"{bag.name}_truth.npz"))
    _, ours, theirs = np.intersect1d(wanted.stamp, truth["stamp"], return_indices=True)
    late = wanted.stamp[ours] - wanted.stamp[0] > SKIP * 1e9
    return wanted.angle[ours][late], truth["theta"][theirs][late]


def other_motion(path: Path, seed: int, seconds: float) -> None:
    """A trajectory file with sums of sines on all joints, from zero and back, at rest at both ends."""
    t = np.arange(0.0, seconds - 0.5, APART)
    rng = np.random.default_rng([seed, 2])
    x = np.clip(np.minimum(t, t[-1] - t) / 2.0, 0.0, 1.0)[:, None]
    position = draw_reference(rng, "multisine", t) * x**3 * (10 - 15 * x + 6 * x**2)
    velocity = np.gradient(position, APART, axis=0)
    slower = min(1.0, TOP_SPEED / np.abs(velocity).max())
    velocity[[0, -1]] = 0.0
    points = [
        {
            "positions": (slower * p).tolist(),
            "velocities": (slower * v).tolist(),
            "time_from_start": float(at),
        }
        for p, v, at in zip(position, velocity, t, strict=True)
    ]
    path.write_text(yaml.safe_dump({"joint_names": list(JOINTS), "points": points}))
