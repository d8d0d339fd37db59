"""``make demo SIMULATOR=mujoco``: a user's MuJoCo arm learns what the real one has, step by step."""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console

from test.concealed.simulators.arm import JOINTS, Real
from test.concealed.simulators.case import Case, draw_case, record
from test.concealed.simulators.proof import errors, trunk

SEED = 4
HIDDEN = Real(
    gap=np.array([0.0, 4e-3, 6e-3]),
    rub=np.array([0.0, 0.6, 0.5]),
    ratio=np.array([0.02, 0.0, 0.0]),
    shown_late=0.03,
)
WHAT = ("2 % of ratio at the shoulder", "backlash at elbow and wrist", "joint readings 30 ms late")


def main(argv: Sequence[str] | None = None) -> int:
    """0 where nine tenths of the error are gone, 1 where not or a step failed."""
    parse = argparse.ArgumentParser(prog="python -m test.concealed.simulators.demo", description=__doc__)
    parse.add_argument("--output", type=Path, default=Path("demo-output"))
    asked = parse.parse_args(argv)
    folder = (asked.output / "mujoco").absolute()
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 120)
    drawn = draw_case(SEED)
    case = Case(SEED, WHAT, replace(HIDDEN), drawn.recorded, drawn.judged)
    try:
        return show(case, folder, console)
    except subprocess.CalledProcessError as error:
        print(f"demo: {' '.join(map(str, error.cmd[2:4]))} failed: see {folder}", file=sys.stderr)
        return 1


def show(case: Case, folder: Path, console: Console) -> int:
    """All steps, each with a line."""
    console.print("[bold]Into the simulator that people have: MuJoCo[/]")
    with console.status("record the arm, and its simulation under the same commands"):
        record(case, folder)
    console.print(f"[green]✓[/] {folder}: bags run and sim, the simulation arm.xml, and arm.yaml")
    steps = (
        ("diagnose", "run", "--against", "sim", "--model", "arm.yaml", "--output", "verdict", "--overwrite"),
        ("export", "verdict/model.yaml", "--to", "mjcf", "--into", "arm.xml", "--output", "exported.xml",
         "--overwrite"),
        ("evaluate", "run", "--against", "sim", "--stage", "wire"),
    )  # fmt: skip
    for words in steps:
        console.print(f"[bold]$ trunk_ros {' '.join(words)}[/]")
        with console.status(words[0]):
            trunk(*words, folder=folder)
        console.print((folder / f"{words[0]}.txt").read_text().rstrip(), markup=False)
    told = errors(case, folder)
    console.print("[bold]The exported model on a motion that was not recorded[/] (rms of the joints, mrad)")
    for joint, before, after in zip(JOINTS, told["before"], told["after"], strict=True):
        console.print(f"  {joint:9} {1e3 * before:7.3f} → {1e3 * after:.3f}")
    console.print(f"{told['gone']:.1%} of the error is gone. What was hidden: {', '.join(case.hidden)}")
    return 0 if told["gone"] >= 0.9 else 1


if __name__ == "__main__":
    sys.exit(main())
