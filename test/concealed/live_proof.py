"""``python -m test.concealed.live_proof --arms 10``: concealed arms on the live graph, before and after.

Each arm is a process of its own on DDS in the place of servo_driver and wire_elasticity. The nominal
compensator drives it through a reference; the recording is diagnosed; the model goes into the compensator;
the same reference is run again. Said is how far the true joints and the true tip were off. Resumable by
arm.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from test.concealed.codes import ROOT, closure, digest, package
from test.concealed.demo_runs import Arm, DemoError, drive, followed, other_motion, trunk
from test.concealed.hide import hide
from test.concealed.marks import matched
from test.concealed.nominal import Array, tip
from test.concealed.seeds import LIVE, LIVE_MANY
from test.concealed.whole import write_whole

KINDS = (
    ("backlash", "presliding_hysteresis", "tension_error", "load_dependent_friction", "stribeck_friction"),
    ("ratio_error", "joint_coupling", "load_elasticity", "transmission_ripple"),
    ("viscous_lag", "zero_offset", "viscoelastic_creep", "sensor_delay"),
)
SECONDS, SECONDS_OF_MANY = 25.0, 60.0
MANY = (5, 8)  # effects of an arm


@cache
def live_code() -> str:
    """Hash of package, nodes and concealed arm: results of other code do not count."""
    return digest(
        package() | set((ROOT / "trunk_ros" / "nodes").rglob("*.py")) | closure("live_proof", "live")
    )


def drawn_effects(seed: int) -> list[str]:
    """One effect of each of three kinds, or several."""
    rng = np.random.default_rng([seed, 4])
    if seed not in LIVE_MANY:
        return [str(rng.choice(kind)) for kind in KINDS]
    every = [name for kind in KINDS for name in kind]
    return [str(name) for name in rng.choice(every, int(rng.integers(MANY[0], MANY[1] + 1)), replace=False)]


def off(wanted: Array, true: Array) -> dict[str, float]:
    """Rms of the true joints (rad) and of the place of the true tip (m) off the reference; angles (n, 5)
    rad.
    """
    joints = float(np.sqrt(((true - wanted) ** 2).mean()))
    apart = (tip(true) - tip(wanted))[:, :2]
    return {"joints": joints, "tip": float(np.sqrt((apart**2).sum(axis=1).mean()))}


def _tried(seed: int, folder: Path, seconds: float) -> dict[str, Any]:
    effects = drawn_effects(seed)
    arm = Arm(seed, ",".join(effects))
    drive(arm, folder / "run_1", seconds, 1)
    trunk("diagnose", folder / "run_1", "--output", folder / "found")
    motion = ("--trajectory", folder / "motion.yaml")
    other_motion(folder / "motion.yaml", seed, seconds)
    drive(arm, folder / "run_2", seconds, 2, *motion)
    drive(arm, folder / "run_3", seconds, 3, *motion, "--model", folder / "found" / "model.yaml")
    diagnosis = json.loads((folder / "found" / "diagnosis.json").read_text())
    truth = [h.told() for h in hide(seed, effects)]
    return {
        "effects": effects,
        "said": [f["effect"] for f in diagnosis["findings"]],
        "named": len(matched(truth, diagnosis["findings"])),
        "before": off(*followed(folder / "run_2")),
        "after": off(*followed(folder / "run_3")),
    }


def tried(seed: int, output: Path, seconds: float = SECONDS) -> dict[str, Any]:
    """The result of an arm, from before where the code is the same; a step that failed is said."""
    kept = output / "live" / f"arm_{seed}.json"
    if kept.exists():
        known: dict[str, Any] = json.loads(kept.read_text())
        if known["code"] == live_code() and known["seconds"] == seconds and "failed" not in known:
            return known
    folder = output / "live" / f"arm_{seed}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        found = _tried(seed, folder, seconds)
    except DemoError as error:
        found = {"effects": drawn_effects(seed), "failed": str(error)}
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    whole = {"seed": seed, "seconds": seconds, "code": live_code(), **found}
    write_whole(kept, whole)
    return whole


def try_all(seeds: range, output: Path, seconds: float, console: Console, name: str) -> list[dict[str, Any]]:
    """Results of arms, with a line each; all of them in the file of that ``name``."""
    out = []
    for seed in seeds:
        began = time.monotonic()
        one = tried(seed, output, seconds)
        out.append(one)
        words = one.get("failed") or (
            f"{1e3 * one['before']['joints']:.2f} -> {1e3 * one['after']['joints']:.3f} mrad, "
            f"{1e3 * one['before']['tip']:.2f} -> {1e3 * one['after']['tip']:.3f} mm"
        )
        console.print(f"arm {seed} ({', '.join(one['effects'])}): {words} ({time.monotonic() - began:.0f} s)")
        write_whole(output / name, out)
    return out


def main(argv: list[str] | None = None) -> int:
    """Command line; 1 where an arm failed."""
    parser = argparse.ArgumentParser(prog="python -m test.concealed.live_proof", description=__doc__)
    parser.add_argument("--arms", type=int, help="only the first ones")
    parser.add_argument("--many", action="store_true", help="arms with five to eight effects at once")
    parser.add_argument("--seconds", type=float, help="length of each run")
    parser.add_argument("--output", type=Path, default=ROOT / "proof")
    asked = parser.parse_args(argv)
    asked.output.mkdir(parents=True, exist_ok=True)
    few, many = (LIVE, SECONDS, "live.json"), (LIVE_MANY, SECONDS_OF_MANY, "live_many.json")
    seeds, usual, name = many if asked.many else few
    console = Console(highlight=False, soft_wrap=True)
    found = try_all(seeds[: asked.arms], asked.output, asked.seconds or usual, console, name)
    return int(any("failed" in one for one in found))


if __name__ == "__main__":
    sys.exit(main())
