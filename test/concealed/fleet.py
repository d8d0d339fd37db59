"""``python -m test.concealed.fleet --output DIR``: concealed fleets, and what `fleet` makes of them.

Arms of one type share an error of a ratio that the simulator lacks. A third of them wears (a dead band that
grows), a fifth slipped on one day, a sixth has another pulley, a tenth carries another payload from a day on.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.bag import write_bag
from test.concealed.draws import ALL
from test.concealed.fleet_tables import DAY, PAYLOAD, PULLEY, SLIP, WEAR, Score, kinds_of
from test.concealed.hidden import Hidden
from test.concealed.nominal import COMPLIANCE, JOINTS, RATIO, Array
from test.concealed.plant import run
from test.concealed.sensing import BASE, PERIOD, Run, Sensing, record
from test.concealed.trajectory import draw_reference

NOISE = 1e-4  # rad
COMMON = Hidden(PULLEY, (3,), "linear", {"relative": np.array([0.004])})
BROKEN = 0.02  # of the recordings


@dataclass
class Arm:
    """What is hidden in one arm, by recording: ``hidden[k]``; what is to be found of it."""

    name: str
    kind: str
    time: Array
    hidden: list[tuple[Hidden, ...]]
    trends: list[tuple[str, str]] = field(default_factory=list)
    changes: list[tuple[str, str, float, float]] = field(default_factory=list)
    """Effect, joint, and the recordings between which it was [s since the epoch]."""


def drawn(rng: np.random.Generator, name: str, kind: str, recordings: int) -> Arm:
    """An arm of a kind."""
    time = BASE * 1e-9 + np.cumsum(rng.uniform(0.2, 4.0, recordings)) * DAY
    joint = int(rng.integers(len(JOINTS)))
    own: list[tuple[Hidden, ...]] = [()] * recordings
    arm = Arm(name, kind, time, own)
    if kind == "wear":
        since = int(rng.integers(0, recordings // 3))
        grown = np.clip((time - time[since]) / (time[-1] - time[since]), 0.0, 1.0)
        width = rng.uniform(3.0, 12.0) * NOISE * grown
        arm.hidden = [(Hidden(WEAR, (joint,), "play", {"half_width": np.array([w])}),) for w in width]
        arm.trends.append((WEAR, JOINTS[joint]))
    elif kind == "slip":
        place, step = (
            int(rng.integers(2, recordings - 2)),
            rng.choice([-1, 1]) * rng.uniform(3.0, 12.0) * NOISE,
        )
        after = (Hidden(SLIP, (joint,), "constant", {"offset": np.array([step])}),)
        arm.hidden = [after if k >= place else () for k in range(recordings)]
        arm.changes.append((SLIP, JOINTS[joint], float(time[place - 1]), float(time[place])))
    elif kind == "payload":
        place, mass = int(rng.integers(2, recordings - 2)), rng.uniform(0.05, 0.2)
        arm.hidden = [(_stretch(mass if k >= place else 0.0),) for k in range(recordings)]
        arm.changes.append((PAYLOAD, "arm", float(time[place - 1]), float(time[place])))
    elif kind == "pulley":
        arm.hidden = [(Hidden(PULLEY, (1,), "linear", {"relative": np.array([0.012])}),)] * recordings
    arm.hidden = [_joined((COMMON, *each)) for each in arm.hidden]
    return arm


def _stretch(payload: float) -> Hidden:
    return Hidden(PAYLOAD, ALL, "wire", {"compliance": COMPLIANCE, "payload": payload})


def _joined(hidden: tuple[Hidden, ...]) -> tuple[Hidden, ...]:
    """Two errors of ratios on different joints are one effect on both."""
    ratios = [h for h in hidden if h.effect == PULLEY]
    if len(ratios) < 2:
        return hidden
    order = sorted(ratios, key=lambda h: h.joints)
    joints = tuple(j for h in order for j in h.joints)
    values = np.concatenate([h.parameters["relative"] for h in order])
    one = Hidden(PULLEY, joints, "linear", {"relative": values})
    return (one, *(h for h in hidden if h.effect != PULLEY))


def recording(rng: np.random.Generator, hidden: tuple[Hidden, ...], time: float, seconds: float) -> Run:
    """One run of an arm at a time [s since the epoch]."""
    t = np.arange(round(seconds / PERIOD), dtype=np.float64) * PERIOD
    kind = str(rng.choice(["multisine", "mixed"]))
    reference = draw_reference(rng, kind, t)
    made = record(
        rng, kind, reference, reference / RATIO, run(hidden, reference / RATIO), Sensing(noise=NOISE)
    )
    later = round(time * 1e9) - BASE
    for topic in made.topics.values():
        topic["stamp"] = topic["stamp"] + later
    return made


def write_fleet(
    folder: Path, seed: int, arms: int, recordings: int, seconds: float, still: bool
) -> tuple[list[Arm], Path]:
    """Bags and their list in ``folder``; what is hidden is returned and not written."""
    rng = np.random.default_rng(seed)
    kinds = ["none"] * arms if still else rng.permutation(kinds_of(arms)).tolist()
    fleet = [drawn(rng, f"arm_{k:02d}", kind, recordings) for k, kind in enumerate(kinds)]
    path = folder / "list.csv"
    folder.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(("arm", "time", "path"))
        for arm in fleet:
            for k, when in enumerate(arm.time):
                bag = folder / arm.name / f"run_{k:02d}"
                if not bag.exists():
                    write_bag(recording(rng, arm.hidden[k], float(when), seconds), bag, seed=k)
                    if rng.uniform() < BROKEN:
                        next(bag.glob("*.mcap")).write_bytes(b"lost")
                rows.writerow((arm.name, repr(float(when)), bag.relative_to(folder)))
    return fleet, path


def judged(told: dict[str, Any], fleet: list[Arm]) -> tuple[Score, Score]:
    """Trends by arm and effect; changes by arm and effect, and those dated within one recording."""
    trends = {(arm.name, effect) for arm in fleet for effect, _ in arm.trends}
    said = {(arm, t["effect"]) for arm, all_ in told["arms"].items() for t in all_["trends"]}
    changes = {(arm.name, change[0]): (arm, change) for arm in fleet for change in arm.changes}
    dated: dict[tuple[str, str], list[float]] = {}
    for arm, all_ in told["arms"].items():
        for change in all_["changes"]:
            dated.setdefault((arm, change["effect"]), []).append(change["time"])
    right = changes.keys() & dated.keys()
    near = sum(any(_near(*changes[key], when) for when in dated[key]) for key in right)
    return (
        Score(len(said & trends), len(trends - said), len(said - trends)),
        Score(len(right), len(changes.keys() - right), len(dated.keys() - right), near),
    )


def _near(arm: Arm, change: tuple[str, str, float, float], when: float) -> bool:
    """Between the right two recordings, or next to them."""
    _, _, before, after = change
    low = max([t for t in arm.time if t < before], default=before)
    high = min([t for t in arm.time if t > after], default=after)
    return bool(low <= when <= high)


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.concealed.fleet", description=__doc__)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--fleets", type=int, default=1)
    parser.add_argument("--arms", type=int, default=30)
    parser.add_argument("--recordings", type=int, default=30, help="of each arm")
    parser.add_argument("--seconds", type=float, default=30.0, help="of each recording")
    parser.add_argument("--still", action="store_true", help="fleets on which nothing changes")
    parser.add_argument("--scheduler")
    args = parser.parse_args(argv)
    trends = changes = Score(0, 0, 0)
    for seed in range(args.fleets):
        bags, out = args.output / f"fleet_{seed}", args.output / f"result_{seed}"
        fleet, path = write_fleet(bags, seed, args.arms, args.recordings, args.seconds, args.still)
        command = [sys.executable, "-m", "trunk_ros", "fleet", str(path), "--output", str(out)]
        command += ["--scheduler", args.scheduler] if args.scheduler else []
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        scores = judged(json.loads((out / "fleet.json").read_text()), fleet)
        trends, changes = trends + scores[0], changes + scores[1]
        print(f"fleet {seed}: trends {scores[0]}, changes {scores[1]}", flush=True)
    print(f"trends: F1 {trends.f1:.3f}; changes: F1 {changes.f1:.3f}")
    print(f"{changes.near} of {changes.right} changes dated within one recording")
    print(f"false: {trends.false + changes.false}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
