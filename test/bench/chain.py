"""Simulation: the wire of five joints at 100 Hz, on one core, beside a bare compiled play."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from test.bench.row import Row
from test.effects.example import everything, motion, stamps
from trunk_ros.chain import Chain, State
from trunk_ros.compiled import Array, compiled
from trunk_ros.model import Model, load_model

JOINTS = 5
RATE = 100.0  # Hz
BLOCK = 60_000  # samples that are handed on at once when streaming: ten minutes
MINUTES = {"1 min": 1, "10 min": 10, "1 h": 60, "10 h": 600}
SIX: dict[str, dict[str, Any]] = {
    "ratio_error": {"relative": np.full(JOINTS, 0.01)},
    "backlash": {"half_width": np.full(JOINTS, 3e-4)},
    "stribeck_friction": {"amplitude": np.full(JOINTS, 3e-4), "velocity": np.full(JOINTS, 0.05)},
    "load_elasticity": {"compliance": np.full(JOINTS, 0.03)},
    "viscoelastic_creep": {"gain": np.full(JOINTS, 0.01), "time_constant": 5.0},
    "sensor_delay": {"delay": 0.012},
}


@compiled
def bare_play(u: Array, width: Array, theta: Array, out: Array) -> None:
    """What the nominal wire costs at least: a play over the same arrays, nothing else."""
    steps, columns = u.shape
    for j in range(columns):
        held, w = theta[j], width[j]
        for k in range(steps):
            held = min(max(held, u[k, j] - w), u[k, j] + w)
            out[k, j] = held
        theta[j] = held


def recording(minutes: float) -> tuple[Array, Array]:
    """Stamps and gearbox angles (n, joints) of a motion without end."""
    stamp = np.arange(round(minutes * 60 * RATE)) / RATE
    return stamp, motion(stamp, JOINTS) / 0.625


def six_effects() -> Model:
    """The nominal arm with six effects, one of which lets all joints see each other."""
    return Model(load_model("trunk").arm, SIX)


def fastest(ways: dict[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """The shortest time [s] of each, taken in turns so that a busy machine slows all alike."""
    best = dict.fromkeys(ways, np.inf)
    for _ in range(repeats):
        for name, way in ways.items():
            begin = time.perf_counter()
            way()
            best[name] = min(best[name], time.perf_counter() - begin)
    return best


def measure() -> Iterator[Row]:
    """Speed, its growth with the recording, memory, and the cost of a tick."""
    yield from speed()
    yield from growth()
    yield from memory()
    yield from tick()


def speed() -> Iterator[Row]:
    """Joint-steps per second over an hour, and what share of a bare play's that is."""
    stamp, x = recording(60)
    nominal, six = Chain(load_model("trunk"), "wire"), Chain(six_effects(), "wire")
    width, out = nominal.arm.dead_band, np.empty_like(x)
    best = fastest(
        {
            "bare play": lambda: bare_play(x, width, x[0].copy(), out),
            "nominal wire": lambda: nominal.run(x, stamp),
            "six effects": lambda: six.run(x, stamp),
            "six effects, inverse": lambda: six.invert(x, stamp),
        },
        repeats=9,
    )
    for name, seconds in best.items():
        yield Row(name, x.size / seconds / 1e6, "million joint-steps/s")
    yield Row("nominal wire over bare play", best["bare play"] / best["nominal wire"], "1", at_least=0.7)
    yield Row("six effects over bare play", best["bare play"] / best["six effects"], "1", at_least=0.05)


def growth() -> Iterator[Row]:
    """Time per sample of recordings of 1 min to 10 h: the longest over the second, where the start no
    longer counts.
    """
    chain = Chain(six_effects(), "wire")
    cost = {}
    for name, minutes in MINUTES.items():
        seconds = fastest({name: lambda m=minutes: stream(chain, m)}, repeats=1 if minutes > 60 else 3)[name]
        cost[name] = seconds / minutes
        yield Row(f"six effects, {name}", seconds, "s")
    yield Row("time per sample, 10 h over 10 min", cost["10 h"] / cost["10 min"], "1", at_most=1.3)


def stream(chain: Chain, minutes: float) -> State | None:
    """Pass a recording through block by block, as from a file."""
    stamp, x = recording(min(minutes, BLOCK / RATE / 60))
    state: State | None = None
    for block in range(max(1, round(minutes * 60 * RATE / len(stamp)))):
        _, state = chain.run(x, stamp + block * len(stamp) / RATE, state)
    return state


def memory() -> Iterator[Row]:
    """Peak memory of a process that streams, and what a longer recording adds."""
    peak = {name: peak_of(minutes) for name, minutes in MINUTES.items() if minutes >= 10}
    for name, megabytes in peak.items():
        yield Row(f"peak memory, {name} streamed", megabytes, "MB")
    yield Row("peak memory, 10 h over 10 min", peak["10 h"] / peak["10 min"], "1", at_most=1.05)


def peak_of(minutes: float) -> float:
    """Peak resident memory [MB] of a process of its own."""
    code = (
        "import resource; from trunk_ros.chain import Chain; from test.bench.chain import *;"
        f"stream(Chain(six_effects(), 'wire'), {minutes});"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(done.stdout)


def tick() -> Iterator[Row]:
    """One control period of a node with every effect that can be compensated."""
    chain, stamp = Chain(everything(JOINTS), "wire", hold_time=True), stamps(20, RATE)
    wanted = motion(stamp, JOINTS, amplitude=0.15)
    for name, way, signal in (("run", chain.run, wanted / 0.625), ("invert", chain.invert, wanted)):
        spent = np.min([ticks(way, signal, stamp) for _ in range(9)], axis=0) * 1e6
        yield Row(f"tick of {len(chain.effects)} effects, {name}", float(np.median(spent)), "us", at_most=100)
        yield Row(f"tick of {len(chain.effects)} effects, {name}, p99", float(np.quantile(spent, 0.99)), "us")
    nominal = Chain(load_model("trunk"), "wire")
    yield Row(
        "tick of the nominal wire, run", float(np.median(ticks(nominal.run, wanted, stamp)) * 1e6), "us"
    )


def ticks(way: Callable[..., Any], signal: Array, stamp: Array) -> Array:
    """(n,) s that each sample takes on its own."""
    state, spent = None, []
    for k in range(len(stamp)):
        begin = time.perf_counter()
        _, state = way(signal[k : k + 1], stamp[k : k + 1], state)
        spent.append(time.perf_counter() - begin)
    return np.array(spent)
