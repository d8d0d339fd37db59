"""``python -m test.space_proof --cases N``: arms in space by their URDF, diagnosed without the answer.

Goes on where it stopped. Writes proof/space.json and proof/space.md.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.codes import ROOT, marks_code
from test.concealed.space_arm import URDFS, Array
from test.concealed.space_case import RATE, Recorded, SpaceCase, draw_case

CASES = 200
SETTLED = int(5 * RATE)  # samples until which the play may begin anywhere


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.space_proof", description=__doc__)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="begin no case later")
    parser.add_argument("--output", type=Path, default=ROOT / "proof")
    args = parser.parse_args(argv)
    begin, marks = time.monotonic(), []
    kept = args.output / "space"
    kept.mkdir(parents=True, exist_ok=True)
    for seed in range(args.cases):
        file = kept / f"{seed}.json"
        if not file.exists() or json.loads(file.read_text())["code"] != marks_code():
            if time.monotonic() - begin > args.seconds:
                break
            file.write_text(json.dumps({"code": marks_code(), **judged(draw_case(seed))}, indent=1))
        marks.append(json.loads(file.read_text()))
        print(f"\r{len(marks)} of {args.cases}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    sums = summary(marks)
    (args.output / "space.json").write_text(json.dumps({"summary": sums, "cases": marks}, indent=1))
    (args.output / "space.md").write_text(table(sums))
    print(table(sums))
    return 0


def told(case: SpaceCase) -> Any:
    """What is said of the motion that was recorded."""
    from trunk_ros.diagnosis import diagnose

    return diagnose([_recording(case, case.train)], _model(case))


def judged(case: SpaceCase) -> dict[str, Any]:
    """Marks of one case: names, joint errors and tip errors on the other motion before and after."""
    began = time.process_time()
    model, result = _model(case), told(case)
    found = [(f.effect, tuple(f.joints), tuple(map(str, f.equivalents))) for f in result.findings]
    hit, false = matched(case, found)
    before, after = (_joint_error(case, each) for each in (model, result.model))
    return {
        "seed": case.seed, "arm": case.arm, "truth": [(h.effect, h.joints) for h in case.truth],
        "found": found, "hit": hit, "false": false, "verdict": result.verdict,
        "removed": 1.0 - (after / before) ** 2 if before > 1e-5 else None,
        "tip": _tip_error(case, result.model),
        "seconds": time.process_time() - began,
    }  # fmt: skip


def matched(case: SpaceCase, found: list[tuple[str, tuple[str, ...], tuple[str, ...]]]) -> tuple[int, int]:
    """Hidden effects that were named, on their joints or as one that says the same; names too many."""
    hit, used = 0, set()
    for hidden in case.truth:
        for k, (name, joints, others) in enumerate(found):
            named = hidden.effect in (name, *others) or name in hidden.same
            if named and (not hidden.joints or not joints or set(joints) & set(hidden.joints)):
                used.add(k)
                hit += 1
                break
        else:
            continue
    truth = {hidden.effect for hidden in case.truth}  # a zero shows in the wires and at the tip
    wrong = [
        k
        for k, (name, _, others) in enumerate(found)
        if k not in used and name != "unknown" and not truth & set(others)
    ]
    return hit, len(wrong)


def _model(case: SpaceCase) -> Any:
    """What a user knows: the URDF and how motors turn joints."""
    from trunk_ros.model import Model

    flat = {"arm.urdf": URDFS[case.arm], "wire.coupling": case.coupling.ravel().tolist()}
    return Model.from_parameters(flat)


def _recording(case: SpaceCase, run: Recorded) -> Any:
    from trunk_ros.recording.recording import JointSeries, PoseSeries, Recording

    series = {
        "gearbox_states": JointSeries(run.stamp, case.joints, run.motors),
        "joint_states": JointSeries(run.stamp, case.joints, run.joints),
    }
    tip = PoseSeries(run.stamp[::2], run.tip[::2, :3], run.tip[::2, 3:])
    return Recording(f"space_{case.seed}", 0, float(run.stamp[-1]), series, tip)


def _joint_error(case: SpaceCase, model: Any) -> float:
    """Rms of what the joint sensors of the other motion would show without noise, less the prediction."""
    from trunk_ros.simulate import simulate

    said: Array = simulate(_recording(case, case.test), model).series["joint_states"].position
    shown = case.test.true + np.median(case.test.joints - case.test.true, axis=0)
    return float(np.sqrt(np.mean((said - shown)[SETTLED:] ** 2)))


def _tip_error(case: SpaceCase, model: Any) -> float:
    """Rms of what is left of the other motion's tip, in the noise of its sensor: the worst of its signals."""
    from trunk_ros.evaluate.score import score
    from trunk_ros.evaluate.source import of_model

    rows = score("test", [of_model(_recording(case, case.test), "found", model)])
    return max(row.in_noise for row in rows if row.stage == "arm")


def summary(marks: list[dict[str, Any]]) -> dict[str, Any]:
    """Recall, precision, what is removed, clean arms with a finding, by arm and in all."""
    out = {}
    for arm in ["all", *sorted({m["arm"] for m in marks})]:
        some = [m for m in marks if arm in ("all", m["arm"])]
        hidden, hit = sum(len(m["truth"]) for m in some), sum(m["hit"] for m in some)
        false, removed = (
            sum(m["false"] for m in some),
            [m["removed"] for m in some if m["removed"] is not None],
        )
        clean = [m for m in some if not m["truth"]]
        out[arm] = {
            "cases": len(some), "recall": hit / hidden if hidden else None,
            "precision": hit / (hit + false) if hit + false else None,
            "removed": float(np.median(removed)) if removed else None,
            "tip_in_noise": float(np.median([m["tip"] for m in some])),
            "clean": len(clean), "clean_with_finding": sum(bool(m["found"]) for m in clean),
            "seconds": float(np.median([m["seconds"] for m in some])),
        }  # fmt: skip
    return out


def table(told: dict[str, Any]) -> str:
    """Markdown of a summary."""
    keys = list(told["all"])
    rows = ["| arm | " + " | ".join(keys) + " |", "|---" * (len(keys) + 1) + "|"]
    for arm, each in told.items():
        values = ("" if each[k] is None else f"{each[k]:.3g}" for k in keys)
        rows.append(f"| {arm} | " + " | ".join(values) + " |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    sys.exit(main())
