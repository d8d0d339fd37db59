"""`make fuzz`: all readers in turn, as many at once as --jobs says; FULL=1 for an hour.

What breaks a reader is kept in fuzz/, and makes this exit with 1. So does a hang of 30 s and 1 GB of memory.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from test.fuzz.targets import FOLDER, TARGETS, new_folder

SHORT, LONG = 48.0, 3600.0  # s in all
HANG, MEGABYTES = 30, 1000
KEPT = Path("fuzz")
COUNT = re.compile(r"stat::number_of_executed_units:\s*(\d+)|#(\d+)\s")
COVERED = re.compile(r"cov: (\d+)")


@dataclass(frozen=True)
class Outcome:
    """Of one reader: inputs tried, places of the code reached, and the last words where it broke."""

    name: str
    inputs: int
    covered: int
    broken: str


def fuzz(name: str, seconds: float) -> Outcome:
    """Mutate the inputs of one reader for so long."""
    kept = KEPT / name
    kept.mkdir(parents=True, exist_ok=True)
    options = [
        f"-max_total_time={max(round(seconds), 1)}", f"-timeout={HANG}", f"-rss_limit_mb={MEGABYTES}",
        "-max_len=65536",        "-print_final_stats=1", f"-artifact_prefix={kept}/",
    ]  # fmt: skip
    command = [sys.executable, "-m", "test.fuzz.one", name, str(kept / "corpus"), *options]
    with new_folder() as folder:
        env = os.environ | {FOLDER: folder}
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=env)
    said = done.stderr.splitlines()
    counts = [int(a or b) for line in said for a, b in COUNT.findall(line)]
    covered = [int(found) for line in said for found in COVERED.findall(line)]
    broken = "" if done.returncode == 0 else "\n".join([*done.stdout.splitlines()[-30:], *said[-12:]])
    return Outcome(name, max(counts, default=0), max(covered, default=0), broken)


def main() -> int:
    """Fuzz and say what came of it."""
    parser = argparse.ArgumentParser(prog="test.fuzz", description=__doc__)
    parser.add_argument("--seconds", type=float, default=LONG if os.environ.get("FULL") else SHORT)
    parser.add_argument("--only", nargs="+", choices=list(TARGETS), default=list(TARGETS))
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="readers at once")
    given = parser.parse_args()
    share = given.seconds * min(given.jobs, len(given.only)) / len(given.only)
    outcomes = []
    with ThreadPoolExecutor(given.jobs) as pool:
        for each in pool.map(lambda name: fuzz(name, share), given.only):
            outcomes.append(each)
            state = "BROKEN" if each.broken else "whole"
            counted = f"{each.inputs:10,d} inputs   {each.covered:5d} places reached"
            print(
                f"{each.name:12} {counted}   {state}",
                each.broken,
                sep="\n" if each.broken else "",
                flush=True,
            )
    print(f"{sum(each.inputs for each in outcomes):,d} inputs; what was found is kept in {KEPT}/")
    return 1 if any(each.broken for each in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
