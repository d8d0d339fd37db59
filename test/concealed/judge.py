"""One case of the proof from its seed to its marks: conceal, diagnose, reveal, score."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import shutil
import time
import traceback
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from test.concealed.marks import marked
from test.concealed.protocol import Answer, Concealed, conceal, kept_shut, reveal
from test.concealed.refit import refit
from test.concealed.removed import removable
from test.concealed.seeds import drawn

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Task:
    """A case to prove on, and the folder of the proof."""

    kind: str
    seed: int
    output: Path

    @property
    def kept(self) -> Path:
        """Where its marks stay."""
        return self.output / "marks" / f"{self.kind}_{self.seed}.json"


@cache
def code() -> str:
    """Short hash of the package and of the proof: marks of other code do not count."""
    total = hashlib.sha256()
    for file in sorted([*(ROOT / "trunk_ros").rglob("*.py"), *Path(__file__).parent.glob("*.py")]):
        if not file.name.startswith(("test_", "proof", "demo", "evidence", "intervals")):
            total.update(file.relative_to(ROOT).as_posix().encode() + file.read_bytes())
    return total.hexdigest()[:12]


def known_marks(task: Task) -> dict[str, Any] | None:
    """Marks from before, of the same code; None where the case is still to be done or failed."""
    if not task.kept.exists():
        return None
    marks: dict[str, Any] = json.loads(task.kept.read_text())
    return None if marks["code"] != code() or marks.get("failed") else marks


def _command(*arguments: Any) -> None:
    """A command of the package in this process. Raises RuntimeError with its last words."""
    from trunk_ros.__main__ import main as run

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as err:
        status = run([str(x) for x in arguments])
    if status:
        raise RuntimeError(f"{arguments[0]} ended with {status}: {err.getvalue().strip()[-400:]}")


def _answered(where: Concealed, out: Path) -> tuple[dict[str, Any], float]:
    """The diagnosis of the first recording, and what it took in s."""
    began = time.perf_counter()
    with kept_shut(where.sealed.parent):
        _command("diagnose", where.folder / "run_1", "--output", out)
    return json.loads((out / "diagnosis.json").read_text()), time.perf_counter() - began


def _removal(where: Concealed, out: Path, answer: Answer) -> dict[str, float]:
    """Rms error of the joint angles of the second recording before and after, rad."""
    on_servo = any(one["stage"] == "servo" for one in answer.told["truth"])
    source = "setpoints" if on_servo else "gearbox_states"
    run_2, predicted = where.folder / "run_2", out / "predicted"
    _command("simulate", run_2, "--model", out / "model.yaml", "--from", source, "--output", predicted)
    noise = answer.told["noise"]["noise"]
    before, after = removable(run_2, predicted, answer.clean, source, noise)
    return {"before": before, "after": after}


def _refitted(where: Concealed, answer: Answer) -> dict[str, Any]:
    """Errors of the baseline on both runs, beside the tool's."""
    runs = (where.folder / "run_1", where.folder / "run_2")
    try:
        return {"refit": refit(*runs, answer.clean, answer.told["noise"]["noise"])}
    except (ValueError, IndexError, FloatingPointError) as error:  # not the tool's fault: said, not scored
        return {"refit_failed": str(error)}


def _about(answer: Answer) -> dict[str, Any]:
    told = answer.told
    return {"count": len(told["truth"]), "known": told["known"], "motion": told["train"],
            "effects": [t["effect"] for t in told["truth"]], "noise": told["noise"]["noise"]}  # fmt: skip


def _marks(where: Concealed, out: Path) -> dict[str, Any]:
    try:
        diagnosis, took = _answered(where, out)
    except Exception as error:  # whatever the diagnosis does, it is marked as having found nothing
        diagnosis, took = {"verdict": "failed", "findings": []}, 0.0
        failed = f"{error}\n{traceback.format_exc()[-1200:]}"
        answer = reveal(where)
        return {
            **_about(answer),
            **marked(answer.told["truth"], diagnosis),
            "failed": failed,
            "seconds": took,
        }
    answer = reveal(where)
    marks = {**_about(answer), **marked(answer.told["truth"], diagnosis), "seconds": took}
    if all(one["stage"] == "wire" for one in answer.told["truth"]):
        marks |= _refitted(where, answer)
    try:
        return {**marks, **_removal(where, out, answer)}
    except Exception as error:  # a model that does not run on another motion has removed nothing
        return {**marks, "failed": f"simulate: {error}"}


def judged(task: Task) -> dict[str, Any]:
    """Marks of a case, kept on disk; its recordings go."""
    name = task.kept.stem
    try:
        case = drawn(task.kind, task.seed)
    except RuntimeError as error:
        return _kept(task, {"name": name, "not_drawn": str(error)})
    where = conceal(case, task.output / "open", task.output / "sealed")
    out = task.output / "answers" / where.folder.name
    try:
        return _kept(task, {"name": name, **_marks(where, out)})
    finally:
        shutil.rmtree(where.folder, ignore_errors=True)
        shutil.rmtree(out, ignore_errors=True)
        where.sealed.unlink(missing_ok=True)


def _kept(task: Task, marks: dict[str, Any]) -> dict[str, Any]:
    whole = {**marks, "kind": task.kind, "seed": task.seed, "code": code()}
    task.kept.parent.mkdir(parents=True, exist_ok=True)
    part = task.kept.with_suffix(".part")
    part.write_text(json.dumps(whole, indent=1))
    part.replace(task.kept)
    return whole
