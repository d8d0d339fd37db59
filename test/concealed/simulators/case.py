"""Arms drawn by seed, recorded as their users would: the arm, and the simulation under the same commands."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from test.concealed.draws import logarithmic
from test.concealed.nominal import Array
from test.concealed.simulators.arm import JOINTS, LENGTH, MASS, TICK, Ran, Real, run, xml
from test.concealed.trajectory import draw_reference
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording

NOISE = 1e-4  # rad
COUNTS = 2**17
SECONDS = 16.0  # of a motion before it is slowed down
HOLDS = np.array([1.5, 0.6, 0.2])  # N m of a bearing in which a link stays where it is within its gap
START = 1_750_000_000_000_000_000
FLAT = ("gap", "rub", "ripple", "late", "shown_late", "ratio")
UPRIGHT = ("payload", "ripple", "late", "shown_late")
FASTEST = 1.5  # rad/s

ARM = """/**:
  ros__parameters:
    arm:
      joints: [{joints}]
      link_length: [{lengths}]
      link_mass: [{masses}]
    wire: {{ratio: [1.0], dead_band: [0.0]}}
"""


@dataclass(frozen=True)
class Case:
    """An arm, what is hidden in it, and commands (n, 3) of two motions: to be recorded, to be judged on."""

    seed: int
    hidden: tuple[str, ...]
    real: Real
    recorded: Array
    judged: Array


def draw_case(seed: int) -> Case:
    """An arm with one to three things its user does not simulate."""
    rng = np.random.default_rng([seed, 20])
    upright = bool(rng.uniform() < 0.35)
    names = list(UPRIGHT if upright else FLAT)
    some = [str(n) for n in rng.choice(names, int(rng.integers(1, 4)), replace=False)]
    some = sorted({*some, "payload"}) if upright else sorted(some)
    if {"gap", "rub"} <= set(some):
        some.remove("rub")  # one joint behind each motor
    real = Real(upright=upright, phase=float(rng.uniform(0, 6)), teeth=float(rng.integers(8, 24)))
    for name in some:
        real = _hide(rng, real, name)
    return Case(seed, tuple(some), real, _motion(rng, "mixed"), _motion(rng, "multisine"))


def _hide(rng: np.random.Generator, real: Real, name: str) -> Real:
    """One thing more, on some joints."""
    on = np.zeros(len(JOINTS))
    on[rng.choice(len(JOINTS), int(rng.integers(1, len(JOINTS) + 1)), replace=False)] = 1.0
    size = np.array([float(logarithmic(rng, 2e-3, 8e-3)) for _ in JOINTS]) * on
    if name == "gap":
        return replace(real, gap=size, rub=HOLDS * on)
    if name == "rub":
        soft = np.array([0.004, 0.006, 0.012]) * on
        return replace(real, soft=soft, rub=np.where(on > 0, size / np.where(on > 0, soft, 1.0), 0.0))
    if name == "ripple":
        return replace(real, ripple=0.5 * size)
    if name == "ratio":
        return replace(real, ratio=5.0 * size * rng.choice([-1.0, 1.0], len(JOINTS)))
    if name == "payload":
        return replace(real, payload=float(rng.uniform(0.1, 0.3)), soft=np.array([0.002, 0.004, 0.008]))
    return replace(real, **{name: float(rng.uniform(0.02, 0.05))})


def _motion(rng: np.random.Generator, kind: str) -> Array:
    """Commands (n, 3) of all joints: a short motion through their ranges, played as slowly as the arm is made
    for.
    """
    stamp = np.arange(round(SECONDS / TICK)) * TICK
    out = 2.0 * draw_reference(rng, kind, stamp)[:, : len(JOINTS)]
    slower = min(1.0, FASTEST / float(np.abs(np.gradient(out, TICK, axis=0)).max()))
    played = np.arange(0.0, stamp[-1], slower * TICK)
    return np.stack([np.interp(played, stamp, one) for one in out.T], axis=1)


def record(case: Case, folder: Path) -> None:
    """``run``, ``sim``, the user's ``arm.xml`` and ``arm.yaml`` in a folder."""
    rng = np.random.default_rng([case.seed, 21])
    real, own = run(case.real, case.recorded), run(Real(upright=case.real.upright), case.recorded)
    count = 2 * np.pi / COUNTS
    seen = Ran(
        np.round(real.motor / count) * count, real.joint + NOISE * rng.standard_normal(real.joint.shape)
    )
    folder.mkdir(parents=True, exist_ok=True)
    write_recording(folder / "run", recording(case.recorded, seen), overwrite=True)
    write_recording(folder / "sim", recording(case.recorded, own), overwrite=True)
    (folder / "arm.xml").write_text(xml(Real(upright=case.real.upright), own=True))
    masses = MASS if case.real.upright else ()
    arm = ARM.format(
        joints=", ".join(JOINTS), lengths=", ".join(map(str, LENGTH)), masses=", ".join(map(str, masses))
    )
    (folder / "arm.yaml").write_text(arm if masses else arm.replace("      link_mass: []\n", ""))


def recording(commands: Array, ran: Ran) -> Recording:
    """What was commanded and seen, as a recording."""
    stamp = np.arange(len(commands)) * TICK
    series = {
        "setpoints": JointSeries(stamp, JOINTS, commands),
        "gearbox_states": JointSeries(stamp, JOINTS, ran.motor),
        "joint_states": JointSeries(stamp, JOINTS, ran.joint),
    }
    return Recording("run", START, float(stamp[-1]), series)
