"""Into a user's MuJoCo: record, diagnose --against, export, run the exported model on another motion.

``python -m test.concealed.simulators.proof --arms 40 --output FOLDER``
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from test.concealed.nominal import Array
from test.concealed.simulators.arm import JOINTS, Real, run
from test.concealed.simulators.case import Case, draw_case, record

SKIP = 300  # ticks at the start
FIRST = 100  # seeds below are for development
SHARE = 0.9  # of the error that is to be gone, in the median


def judge(seed: int, folder: Path) -> dict[str, Any]:
    """One arm, all the way; errors rad rms, by joint, on a motion that was not recorded."""
    case = draw_case(seed)
    record(case, folder)
    began = time.monotonic()
    trunk("diagnose", "run", "--against", "sim", "--model", "arm.yaml", "--output", "verdict", folder=folder)
    took = time.monotonic() - began
    trunk(
        "export", "verdict/model.yaml", "--to", "mjcf", "--into", "arm.xml", "--output", "exported.xml",
        folder=folder,
    )  # fmt: skip
    return {"seed": seed, "hidden": case.hidden, "seconds": took, **errors(case, folder)}


def errors(case: Case, folder: Path) -> dict[str, Any]:
    """Of the user's simulation and of the exported one, against the arm."""
    np.save(folder / "judged.npy", case.judged)
    python("test.export.run_exported", str(folder))
    truth = run(case.real, case.judged).joint
    before = rms(run(Real(upright=case.real.upright), case.judged).joint - truth)
    after = rms(np.load(folder / "shown.npy") - truth)
    told = json.loads((folder / "verdict" / "diagnosis.json").read_text())
    gone = 1.0 - np.sqrt(np.sum(after**2) / np.sum(before**2))
    return {
        "verdict": told["verdict"],
        "found": [f["effect"] for f in told["findings"]],
        "before": before.tolist(),
        "after": after.tolist(),
        "gone": float(gone),
    }


def rms(off: Array) -> Array:
    """(joints,) rad, after the start."""
    return np.asarray(np.sqrt(np.mean(off[SKIP:] ** 2, axis=0)))


def trunk(*words: str, folder: Path) -> None:
    """A command of trunk_ros, in a folder. Raises CalledProcessError."""
    done = subprocess.run(
        [sys.executable, "-m", "trunk_ros", *words], cwd=folder, capture_output=True, text=True, check=False
    )
    (folder / f"{words[0]}.txt").write_text(done.stdout + done.stderr)
    done.check_returncode()


def python(module: str, *words: str) -> None:
    """A module of the tests in a process of its own: the plants reach none of the physics under test."""
    subprocess.run([sys.executable, "-m", module, *words], check=True)


def table(rows: list[dict[str, Any]]) -> Table:
    """A line for each arm."""
    out = Table("arm", "hidden", "found", box=None)
    for head in ("before mrad", "after mrad", "gone"):
        out.add_column(head, justify="right")
    for row in rows:
        sizes = ("/".join(f"{1e3 * v:.2f}" for v in row[key]) for key in ("before", "after"))
        out.add_row(
            str(row["seed"]), ", ".join(row["hidden"]), ", ".join(row["found"]), *sizes, f"{row['gone']:.1%}"
        )
    return out


def main() -> int:
    """0 where the median is reached and no arm is worse."""
    parse = argparse.ArgumentParser(description=__doc__)
    parse.add_argument("--arms", type=int, default=40)
    parse.add_argument("--first", type=int, default=FIRST)
    parse.add_argument("--output", type=Path, default=Path("proof/simulators"))
    asked = parse.parse_args()
    rows, console = [], Console(width=160)
    for seed in range(asked.first, asked.first + asked.arms):
        rows.append(judge(seed, (asked.output / f"arm_{seed}").absolute()))
        console.print(table(rows[-1:]))
        (asked.output / "simulators.json").write_text(json.dumps(rows, indent=1) + "\n")
    gone = np.array([row["gone"] for row in rows])
    console.print(
        f"{len(gone)} arms, joints {', '.join(JOINTS)}: {np.median(gone):.1%} of the error gone in the"
    )
    console.print(f"median, {gone.min():.1%} at the least; {(gone < 0).sum()} arms are worse")
    return 0 if np.median(gone) >= SHARE and gone.min() >= 0.0 else 1


if __name__ == "__main__":
    sys.exit(main())
