"""From a table of angles to a verdict, and to a prediction of a run that the fit has not seen. No ROS.

The two tables stand for yours: a joint behind a cable with 3 mrad of backlash, read 12 ms late.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from trunk_ros.diagnosis import diagnose
from trunk_ros.model import load_model
from trunk_ros.recording.recording import Recording

RATE, SECONDS = 100.0, 40.0
HALF_WIDTH, LATE, NOISE = 3e-3, 0.012, 1e-4  # rad, s, rad


def measure(folder: Path, seed: int) -> Path:
    """A table t, motor_deg, joint_deg as a logger would write it; returns its path."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    rates, phases = rng.uniform(0.05, 0.6, 5), rng.uniform(0.0, 6.0, 5)
    motor = 0.15 * np.sin(2.0 * np.pi * np.outer(t, rates) + phases).sum(axis=1)
    joint = np.empty_like(motor)
    here = motor[0]
    for k, angle in enumerate(motor):
        here = joint[k] = min(max(here, angle - HALF_WIDTH), angle + HALF_WIDTH)
    shown = np.interp(t - LATE, t, joint) + rng.normal(0.0, NOISE, len(t))
    path = folder / f"run{seed}.csv"
    table = np.column_stack([t, np.degrees(motor), np.degrees(shown)])
    np.savetxt(path, table, delimiter=",", header="t,motor_deg,joint_deg", comments="")
    return path


def read(path: Path) -> Recording:
    """The recording that a table is."""
    data = np.genfromtxt(path, delimiter=",", names=True)
    return Recording.from_arrays(
        data["t"], motor=data["motor_deg"], joint=data["joint_deg"], joints=["elbow"], unit="deg"
    )


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        seen, unseen = (read(measure(Path(folder), run)) for run in (1, 2))
    result = diagnose(seen, model="direct")
    print(result)
    for name, model in (("ideal transmission", load_model("direct")), ("fitted model", result.model)):
        print(f"{name}: {1e3 * model.score(unseen)['elbow']:.2f} mrad rms on run 2")
