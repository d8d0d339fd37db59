"""What the hidden physics itself would remove, run over the recorded gearbox angles, which are rounded to an
encoder's counts: ``python -m test.concealed.ceiling --seeds 7000:7160``. From those alone no more can be had.
"""

from __future__ import annotations

import argparse
import sys
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from test.concealed.case import Case
from test.concealed.generate import seeds_of
from test.concealed.nominal import STEP
from test.concealed.plant import moved
from test.concealed.removed import SKIP, Angles, at_stamps, nominal_angle
from test.concealed.seeds import KNOBS, drawn

BOUNDS = (0.2, 1.0, 4.0, np.inf)  # error of the nominal arm over the noise


def errors(case: Case) -> tuple[float, float]:
    """Rms error of the nominal arm and of the hidden one on the second run, over the sensor's noise."""
    gearbox, joints = case.test.topics["gearbox_states"], case.test.topics["joint_states"]
    angles = Angles(gearbox["stamp"], gearbox["position"])
    seconds = (gearbox["stamp"] - gearbox["stamp"][0]) * 1e-9
    fine = np.arange(round(seconds[-1] / STEP) + 1) * STEP
    spline = CubicSpline(seconds, gearbox["position"], axis=0)
    theta = moved(case.hidden, spline(fine), spline(fine, 1)).theta
    stamp = joints["stamp"]
    hidden = at_stamps(stamp, Angles(gearbox["stamp"][0] + np.round(fine * 1e9).astype(np.int64), theta))
    late = stamp - stamp[0] > SKIP * 1e9
    off = [(said - case.test.theta_clean)[late] for said in (nominal_angle(angles, stamp), hidden)]
    before, after = (float(np.sqrt(np.mean(e**2))) / case.noise["noise"] for e in off)
    return before, after


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.concealed.ceiling", description=__doc__)
    parser.add_argument("--seeds", type=seeds_of, default=range(7000, 7160), help="FIRST:LAST")
    parser.add_argument("--kind", choices=[k for k in KNOBS if "clean" not in k], default="singles")
    args = parser.parse_args(argv)
    cases = (drawn(args.kind, seed) for seed in args.seeds)
    found = [errors(case) for case in cases if all(h.stage == "wire" for h in case.hidden)]
    before, after = np.array(found).T
    for low, high in (*pairwise(BOUNDS), (BOUNDS[0], BOUNDS[-1])):
        some = (before > low) & (before <= high)
        removed = 1.0 - after[some] / before[some]
        share = f"at least 80 % in {np.mean(removed >= 0.8):.2f}"
        print(f"{low:g} … {high:g} noise: {some.sum()} cases, median {np.median(removed):.3f}, {share}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
