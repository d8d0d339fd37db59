"""``python -m test.concealed.score DIR``: diagnoses every case of a folder, marks the answers. Resumable."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import subprocess
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np

from test.concealed.labelled import labelled_truth
from test.concealed.marks import marked
from test.concealed.removed import removable
from test.concealed.summary import as_text, summed_up

SCHEMA = Path(__file__).parents[2] / "trunk_ros" / "diagnosis" / "verdict" / "diagnosis.schema.json"


@dataclass(frozen=True)
class Job:
    """One case to diagnose: its folder, what is true, where the answers go."""

    folder: Path
    told: dict[str, Any]
    output: Path
    apart: bool = False
    diagnose_only: bool = False


def _command(job: Job, arguments: list[str]) -> None:
    """Runs a command of the package, in this process or apart; raises RuntimeError with its last words."""
    if job.apart:
        done = subprocess.run([sys.executable, "-m", "trunk_ros", *arguments], capture_output=True, text=True)
        code, said = done.returncode, done.stderr
    else:
        from trunk_ros.__main__ import main as run

        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as err:
            code = run(arguments)
        said = err.getvalue()
    if code:
        raise RuntimeError(f"{arguments[0]} ended with {code}: {said.strip()[-400:]}")


def _marks(job: Job) -> dict[str, Any]:
    train, test = (str(job.folder / which) for which in ("train", "test"))
    found, predicted = job.output / "diagnosis", job.output / "predicted"
    began = time.perf_counter()
    _command(job, ["diagnose", train, "--output", str(found), "--overwrite"])
    took = time.perf_counter() - began
    said = json.loads((found / "diagnosis.json").read_text())
    jsonschema.validate(said, json.loads(SCHEMA.read_text()))
    allowed = job.told["noise"].get("allowed", ())
    marks = {**marked(job.told["truth"], said, allowed), "seconds": took}
    if job.diagnose_only:
        return marks
    source = "setpoints" if any(t["stage"] == "servo" for t in job.told["truth"]) else "gearbox_states"
    model = str(found / "model.yaml")
    _command(
        job, ["simulate", test, "--model", model, "--from", source, "--output", str(predicted), "--overwrite"]
    )
    hidden = job.folder / "clean.npz"
    clean = np.load(hidden)["test"] if hidden.exists() else None
    before, after = removable(job.folder / "test", predicted, clean, source, job.told["noise"]["noise"])
    return {**marks, "before": before, "after": after}


def diagnosed(job: Job) -> dict[str, Any]:
    """The marks of one case, kept in score.json; what failed has found nothing, and is tried again."""
    kept = job.output / "score.json"
    before = json.loads(kept.read_text()) if kept.exists() else {"failed": True}
    if "failed" not in before:
        return dict(before)
    job.output.mkdir(parents=True, exist_ok=True)
    truth = job.told["truth"]
    about = {"name": job.folder.name, "count": len(truth), "known": job.told["known"],
             "noise": job.told["noise"]["noise"], "seconds": 0.0}  # fmt: skip
    try:
        marks = _marks(job)
    except Exception as error:  # whatever the diagnosis does, the other cases go on
        missed = [[t["effect"], t.get("strength")] for t in truth]
        why = f"{error}\n{traceback.format_exc()[-1500:]}"
        marks = {"hits": [], "missed": missed, "false": [], "confidence": [], "failed": why}
    marks = {**about, **marks}
    kept.write_text(json.dumps(marks, indent=1))
    return marks


def jobs(folder: Path, label: str, **options: Any) -> list[Job]:
    """All whole cases of a folder, or those of a labels.json beside the recordings."""
    out = Path(options.pop("results", None) or folder / "results") / label
    if (folder / "labels.json").exists():
        return [
            Job(folder / name, told, out / name, **options) for name, told in labelled_truth(folder).items()
        ]
    found = sorted(folder.glob("case_*/truth.json"))
    return [Job(f.parent, json.loads(f.read_text()), out / f.parent.name, **options) for f in found]


def run(todo: list[Job], workers: int) -> list[dict[str, Any]]:
    """Marks of all jobs, in their order, with a line of progress."""
    if workers <= 1:
        return [diagnosed(job) for job in todo]
    with ProcessPoolExecutor(workers) as pool:
        running = [pool.submit(diagnosed, job) for job in todo]
        for done, future in enumerate(as_completed(running), 1):
            name = future.result()["name"]
            print(f"\r{done}/{len(running)} {name}   ", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return [future.result() for future in running]


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.concealed.score", description=__doc__)
    parser.add_argument("folder", type=Path, help="cases of test.concealed.generate, or labelled recordings")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument(
        "--label", default="last", help="name of this round; a finished case is not run again"
    )
    parser.add_argument("--results", type=Path, help="where answers go, default FOLDER/results")
    parser.add_argument("--cases", help="FIRST:LAST of the sorted cases")
    parser.add_argument("--apart", action="store_true", help="each command in a process of its own")
    parser.add_argument("--diagnose-only", action="store_true", help="do not judge on the test run")
    args = parser.parse_args(argv)
    options = {"apart": args.apart, "diagnose_only": args.diagnose_only, "results": args.results}
    todo = jobs(args.folder, args.label, **options)
    if args.cases:
        first, _, last = args.cases.partition(":")
        todo = todo[int(first) : int(last)]
    cases = run(todo, args.workers)
    summary = summed_up(cases)
    where = Path(args.results or args.folder / "results") / f"{args.label}.json"
    where.write_text(json.dumps({"summary": summary, "cases": cases}, indent=1))
    print(as_text(summary))
    return 0


if __name__ == "__main__":
    sys.exit(main())
