"""``python -m test.fleet.proof_watch``: how soon `watch` sees a change, and how often it cries without one.

The arms are those of the proof: their plants share no code with the monitor.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator

import numpy as np

from test.concealed.hidden import Hidden
from test.concealed.nominal import RATIO, Array
from test.concealed.plant import run
from test.concealed.sensing import PERIOD, Run, Sensing, record
from test.concealed.trajectory import draw_reference
from trunk_ros.fleet.watch.detector import LEARNT, Detector
from trunk_ros.fleet.watch.monitor import LOOK, TOLERATED, WEEK, Change, Monitor
from trunk_ros.fleet.watch.regimes import REGIMES
from trunk_ros.model import load_model

NOISE = 1e-4
STRENGTH = 3.0  # rms of the change over the noise
USUAL = 180.0  # s before a change
SOON = 10.0  # s
TESTS = 2 * 5 * len(REGIMES)
KINDS = {
    "backlash": ("play", "half_width"), "zero_offset": ("constant", "offset"),
    "ratio_error": ("linear", "relative"), "viscous_lag": ("first_order", "time_constant"),
}  # fmt: skip


def moved(rng: np.random.Generator, hidden: tuple[Hidden, ...], reference: Array) -> Run:
    """A recording of an arm with something hidden in it."""
    motion = run(hidden, reference / RATIO)
    return record(rng, "multisine", reference, reference / RATIO, motion, Sensing(noise=NOISE))


def of_strength(rng: np.random.Generator, reference: Array) -> Hidden:
    """A change on one joint whose rms over this motion is STRENGTH times the noise."""
    effect = str(rng.choice([name for name in KINDS if name != "viscous_lag"]))
    form, parameter = KINDS[effect]
    joint = int(rng.integers(5))
    plain = run((), reference / RATIO).theta

    def hidden(size: float) -> Hidden:
        return Hidden(effect, (joint,), form, {parameter: np.array([size])})

    trial = 1e-3 if effect != "ratio_error" else 1e-2
    shift = run((hidden(trial),), reference / RATIO).theta - plain
    return hidden(trial * STRENGTH * NOISE / float(np.sqrt(np.mean(shift[:, joint] ** 2))))


def fed(monitor: Monitor, made: Run, start: float) -> list[Change]:
    """What a monitor says of a run whose first sample is at ``start`` s."""
    topics, found = made.topics, []
    first = topics["joint_states"]["stamp"][0]
    takes = {
        "setpoints": monitor.setpoints,
        "gearbox_states": monitor.gearbox,
        "joint_states": monitor.joint_states,
    }
    stamps = start + (topics["joint_states"]["stamp"] - first) * 1e-9
    for k, at in enumerate(stamps.tolist()):
        for name, take in takes.items():
            take(at, topics[name]["position"][k])
        if k % 25 == 24:
            found += monitor.look()
    return found


def delays(arms: int) -> Iterator[tuple[float, int]]:
    """s until a change was seen on its joint (inf: never), and false alarms before it, for each arm."""
    for seed in range(arms):
        rng = np.random.default_rng(seed)
        t = np.arange(round((USUAL + 2 * SOON) / PERIOD)) * PERIOD
        reference = draw_reference(rng, "multisine", t)
        cut = round(USUAL / PERIOD)
        monitor = Monitor(load_model("trunk"))
        before = fed(monitor, moved(rng, (), reference[:cut]), 0.0)
        change = of_strength(rng, reference[cut:])
        monitor.restart()
        seen = fed(monitor, moved(rng, (change,), reference[cut:]), USUAL + 1.0)
        joint = f"joint_{change.joints[0] + 1}"
        hits = [c.seen - USUAL - 1.0 for c in seen if c.joint == joint]
        yield min(hits, default=np.inf), len(before)


def cries(hours: float, seed: int = 0) -> int:
    """False alarms on a clean arm that moves for so long, minute by minute another motion."""
    rng, monitor, found = np.random.default_rng(seed), Monitor(load_model("trunk")), 0
    for minute in range(round(hours * 60)):
        reference = draw_reference(rng, "multisine", np.arange(6000) * PERIOD)
        found += len(fed(monitor, moved(rng, (), reference), 62.0 * minute))
    return found


def alarms_of_numbers(days: int, step: int = 10) -> int:
    """False alarms of all tests over so many days, on numbers as the tests get them."""
    rng, found = np.random.default_rng(1), 0
    alpha = 0.1 / (TESTS * WEEK / LOOK)
    for begun in range(0, days, step):
        tests = TESTS * min(step, days - begun)
        detector = Detector(tests, alpha, TOLERATED, 1.0 / np.sqrt(50.0))
        ready, since = np.ones(tests, dtype=bool), np.zeros(tests)
        for _ in range(LEARNT + round(86_400 / LOOK)):
            passed = detector.update(rng.normal(size=tests) * 0.3, ready, since)
            found += int(passed.sum())
            detector.evidence[passed] = 0.0
    return found


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.fleet.proof_watch", description=__doc__)
    parser.add_argument("--arms", type=int, default=100)
    parser.add_argument("--hours", type=float, default=2.0, help="of clean motion, sample by sample")
    parser.add_argument("--days", type=int, default=100, help="of clean motion, number by number")
    args = parser.parse_args(argv)
    told = list(delays(args.arms))
    soon = sum(delay <= SOON for delay, _ in told)
    print(f"seen within {SOON:g} s: {soon} of {len(told)}; median {np.median([d for d, _ in told]):.1f} s")
    print(f"false alarms before the changes: {sum(early for _, early in told)}")
    print(f"false alarms in {args.hours:g} h of samples: {cries(args.hours)}")
    print(f"false alarms in {args.days} days of numbers: {alarms_of_numbers(args.days)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
