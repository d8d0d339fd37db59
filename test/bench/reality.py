"""Reality layer: commands and joint states of thousands of environments, one core."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from test.bench.chain import JOINTS, six_effects
from test.bench.row import Row
from trunk_ros.export.reality import RealityLayer

DT = 0.01  # s
STEPS, REPEATS = 60, 7
ENVIRONMENTS = (1, 256, 4096)


def measure() -> Iterator[Row]:
    """Joint-steps a second of processor time with six effects; of many environments there is a target."""
    for environments in ENVIRONMENTS:
        speed = environments * JOINTS / seconds(environments) / 1e6
        least = 10.0 if environments == max(ENVIRONMENTS) else None
        yield Row(f"six effects, {environments} environments", speed, "million joint-steps/s", at_least=least)
    yield Row("step of one environment", seconds(1) * 1e6, "us")


def seconds(environments: int) -> float:
    """Processor time [s] of a step, the shortest of some runs."""
    layer = RealityLayer(six_effects(), environments)
    turn = np.random.default_rng(0).uniform(0.0, 6.0, (environments, JOINTS))
    commands = [0.3 * np.sin(0.05 * k + turn) for k in range(STEPS)]
    state = 0.6 * commands[0]
    layer.step(commands[0], state, DT)
    spent = []
    for _ in range(REPEATS):
        begin = time.process_time()
        for command in commands:
            layer.step(command, state, DT)
        spent.append(time.process_time() - begin)
    return min(spent) / STEPS
