"""One case of the proof from its seed to its marks: conceal, diagnose, reveal, score, compare."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed import others
from test.concealed.codes import marks_code
from test.concealed.marks import marked
from test.concealed.protocol import Answer, Concealed, conceal, reveal
from test.concealed.removed import removable
from test.concealed.seeds import CONCEALED, drawn
from test.concealed.solver import Said, command, diagnosed
from test.concealed.whole import write_whole

Marks = dict[str, Any]
NOTHING: Marks = {"verdict": "failed", "findings": []}


@dataclass(frozen=True)
class Task:
    """A case to prove on, and the folder of the proof."""

    kind: str
    seed: int
    output: Path

    @property
    def name(self) -> str:
        """Kind and seed."""
        return f"{self.kind}_{self.seed}"

    @property
    def kept(self) -> Path:
        """Where its marks stay."""
        return self.output / "marks" / f"{self.name}.json"

    @property
    def others(self) -> Path:
        """Where what others make of it stays."""
        return self.output / "others" / f"{self.name}.json"


def _known_own(task: Task) -> Marks | None:
    if not task.kept.exists():
        return None
    marks: Marks = json.loads(task.kept.read_text())
    return None if marks["code"] != marks_code() or marks.get("failed") else marks


def known_marks(task: Task) -> Marks | None:
    """Marks from before, of the same code; None where the case is still to be done or failed."""
    marks, compared = _known_own(task), others.known(task.others)
    if marks is None or (compared is None and _is_compared(task, marks)):
        return None
    return {**marks, "others": compared or {}}


def _is_compared(task: Task, marks: Marks) -> bool:
    """Whether there is anything in the joint angles for others to learn."""
    return task.kind in CONCEALED and marks.get("source") is not None


def _source(answer: Answer) -> str | None:
    """What predictions start from; None where the joints do what the nominal arm does."""
    stages = {one["stage"] for one in answer.told["truth"]}
    return "setpoints" if "servo" in stages else "gearbox_states" if "wire" in stages else None


def _removal(where: Concealed, out: Path, answer: Answer) -> Marks:
    """Rms error of the joint angles of the second recording before and after, rad."""
    source = _source(answer) or "gearbox_states"
    run_2, predicted = where.folder / "run_2", out / "predicted"
    try:
        command("simulate", run_2, "--model", out / "model.yaml", "--from", source, "--output", predicted)
        before, after = removable(run_2, predicted, answer.clean, source, answer.told["noise"]["noise"])
    except Exception as error:  # a model that does not run on another motion has removed nothing
        return {"failed": f"simulate: {error}"}
    return {"before": before, "after": after}


def _on_the_fitted_run(diagnosis: Marks, answer: Answer) -> Marks:
    """The same for the first recording, on samples that the fit did not see, as the diagnosis says itself."""
    if _source(answer) != "gearbox_states":  # of several stages it says each by itself
        return {}
    noise = answer.told["noise"]["noise"]
    joints = diagnosis.get("stages", {}).get("wire", {}).get("joints", {}).values()
    both = np.array([[one["rmse_before"], one["rmse_after"]] for one in joints], dtype=np.float64)
    if not both.size or not np.isfinite(both).all():
        return {}
    left = np.sqrt(np.maximum((both**2).mean(axis=0) - noise**2, 0.0))
    return {"fitted_before": float(left[0]), "fitted_after": float(left[1])}


def _about(answer: Answer) -> Marks:
    told = answer.told
    return {"count": len(told["truth"]), "known": told["known"], "motion": told["train"],
            "effects": [t["effect"] for t in told["truth"]], "noise": told["noise"]["noise"],
            "source": _source(answer)}  # fmt: skip


def _own(where: Concealed, said: Said, out: Path, answer: Answer) -> Marks:
    """Marks of the diagnosis; one that failed has found nothing."""
    if said.failed:
        return {
            **_about(answer),
            **marked(answer.told["truth"], NOTHING),
            "failed": said.failed,
            "seconds": 0.0,
        }
    diagnosis = json.loads((out / "diagnosis.json").read_text())
    return {
        **_about(answer),
        **marked(answer.told["truth"], diagnosis, answer.told["noise"].get("allowed", ())),
        **_on_the_fitted_run(diagnosis, answer),
        **_removal(where, out, answer),
        "seconds": said.seconds,
    }


def judged(task: Task) -> Marks:
    """Marks of a case, kept on disk; its recordings go."""
    try:
        case = drawn(task.kind, task.seed)
    except RuntimeError as error:
        return _kept(task, {"name": task.name, "not_drawn": str(error)})
    where = conceal(case, task.output / "open", task.output / "sealed")
    own = task.output / "answers" / where.folder.name
    own.mkdir(parents=True)
    out = own / "diagnosis"
    try:
        marks = _known_own(task)
        if marks is None:
            said = diagnosed(task.output, where.folder / "run_1", out)
            answer = reveal(where)
            marks = _kept(task, {"name": task.name, **_own(where, said, out, answer)})
        return {**marks, "others": _compared(task, where, marks)}
    finally:
        shutil.rmtree(where.folder, ignore_errors=True)
        shutil.rmtree(own, ignore_errors=True)
        where.sealed.unlink(missing_ok=True)


def _compared(task: Task, where: Concealed, marks: Marks) -> Marks:
    """What others make of the case, from before where their code is the same."""
    if not _is_compared(task, marks):
        return {}
    before = others.known(task.others)
    if before is not None:
        return before
    runs, answer = (where.folder / "run_1", where.folder / "run_2"), reveal(where)
    found = others.compared(runs, marks["source"], answer.clean, answer.told["noise"]["noise"])
    return others.keep(task.others, found)


def _kept(task: Task, marks: Marks) -> Marks:
    whole = {**marks, "kind": task.kind, "seed": task.seed, "code": marks_code()}
    write_whole(task.kept, whole)
    return whole
