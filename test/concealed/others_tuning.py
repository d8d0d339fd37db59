"""``python -m test.concealed.others_tuning``: the comparisons' settings, tried on cases that the proof
never draws.

Prints, for each method and setting, the median share of the error removed on the second run, and takes the
best.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.bag import write_bag
from test.concealed.boosted import Boosted
from test.concealed.case import Case, draw_case
from test.concealed.echo import Echo
from test.concealed.mujoco_case import draw_mujoco_case
from test.concealed.nominal import Array
from test.concealed.seeds import KNOBS
from test.concealed.seen import Seen, look_at
from test.concealed.symbolic import Symbolic

FIRST = 40_000  # seeds from here on; the proof's begin at 50 000
REMOVABLE = 0.2  # of the noise
GRIDS: dict[Callable[..., Any], dict[str, tuple[Any, ...]]] = {
    Boosted: {"learning_rate": (0.05, 0.1), "max_leaf_nodes": (4, 15), "min_samples_leaf": (40, 200)},
    Symbolic: {"degree": (1, 2), "threshold": (0.1, 0.3, 1.0), "alpha": (1.0, 100.0)},
    Echo: {"radius": (0.5, 0.9), "slowest": (0.1, 1.0), "ridge": (0.01, 0.1), "inputs": (0.03, 0.1)},
}  # fmt: skip


def _case(n: int) -> Case:
    """In turn single effects, two, three, hard recordings, and arms in MuJoCo."""
    kind = ("singles", "pairs", "singles", "triples", "hard", "mujoco")[n % 6]
    return draw_mujoco_case(FIRST + n) if kind == "mujoco" else draw_case(FIRST + n, **KNOBS[kind])


def tuning_cases(many: int) -> Iterator[tuple[Seen, Seen, Array]]:
    """First and second recording and the noise-free angle of the second, where the wire errs at all."""
    with tempfile.TemporaryDirectory() as folder:
        for n in range(many):
            case = _case(n)
            if any(one["stage"] != "wire" for one in case.truth):
                continue
            runs = [Path(folder) / f"{n}_{k}" for k in (1, 2)]
            for run, motion in zip(runs, (case.train, case.test), strict=True):
                write_bag(motion, run)
            first, second = (look_at(run, "gearbox_states") for run in runs)
            if second.error(second.nominal, case.test.theta_clean, 0.0) > REMOVABLE * case.noise["noise"]:
                yield first, second, case.test.theta_clean


def shares(method: Callable[..., Any], cases: list[tuple[Seen, Seen, Array]], **settings: Any) -> Array:
    """Share of the error removed on the second run of each case."""
    out = []
    for first, second, clean in cases:
        said = second.nominal + method(first, **settings).residual(second)
        out.append(1 - second.error(said, clean, 0.0) / second.error(second.nominal, clean, 0.0))
    return np.array(out)


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.concealed.others_tuning", description=__doc__)
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--methods", default="Boosted,Symbolic,Echo")
    asked = parser.parse_args(argv)
    cases = list(tuning_cases(asked.cases))
    print(f"{len(cases)} cases from seed {FIRST} on")
    for method, grid in GRIDS.items():
        if method.__name__ not in asked.methods.split(","):
            continue
        tried = []
        for values in itertools.product(*grid.values()):
            settings = dict(zip(grid, values, strict=True))
            began = time.perf_counter()
            found = shares(method, cases, **settings)
            seconds = (time.perf_counter() - began) / len(cases)
            tried.append((float(np.median(found)), float(np.mean(found < 0)), seconds, settings))
        for median, worse, seconds, settings in sorted(tried, key=lambda one: -one[0])[:8]:
            print(
                f"{method.__name__}: median {median:.3f}, worse {worse:.2f}, {seconds:.2f} s, {settings}",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
