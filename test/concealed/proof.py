"""``make proof``: arms with concealed physics, diagnosed without the answer, then scored. Resumable by seed.

A part in at most ten minutes; ``FULL=1`` in the environment: everything. Both write ``proof/``: results.json,
table.md and figures.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from test.concealed.codes import ROOT, marks_code
from test.concealed.evidence import as_json, evidence
from test.concealed.evidence_others import live, shares_by_way
from test.concealed.judge import Task, judged, known_marks
from test.concealed.paper_case import paper_rows
from test.concealed.proof_comparisons import draw_comparisons
from test.concealed.proof_figures import draw_figures
from test.concealed.proof_page import update_page
from test.concealed.proof_table import Beside, as_markdown
from test.concealed.seeds import CLEAN, CONCEALED, in_turn

PART_SECONDS = 450.0  # no case begins later in a part; the last one and the figures fit into ten minutes
GRACE = 100.0  # s for cases that have begun; what is not done by then is left for the next time
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class ProofError(Exception):
    """The proof cannot go on; one line."""


def parser() -> argparse.ArgumentParser:
    """Arguments; FULL=1 in the environment is --full."""
    asked = argparse.ArgumentParser(prog="python -m test.concealed.proof", description=__doc__)
    asked.add_argument("--full", action="store_true", default=os.environ.get("FULL", "") not in ("", "0"))
    asked.add_argument("--output", type=Path, default=ROOT / "proof")
    asked.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    asked.add_argument(
        "--seconds", type=float, help="begin no case later, default 450 for the part, none for all"
    )
    asked.add_argument("--cases", type=int, help="only so many, in the order of the proof")
    asked.add_argument(
        "--after", type=int, default=0, help="leave out so many of that order: those that a version has seen"
    )
    asked.add_argument("--kinds", nargs="+", default=(), choices=(*CONCEALED, *CLEAN), help="only these")
    asked.add_argument("--page", action="store_true", help="only put the last table and figures into docs/")
    return asked


def _running(todo: list[Task], workers: int, deadline: float) -> Iterator[dict[str, Any]]:
    """Marks as they come; none begins after the deadline, none ends later than the grace after it."""
    context = multiprocessing.get_context("spawn")  # nothing of this process but the code
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        left = iter(todo)
        running: set[Future[dict[str, Any]]] = set()
        while True:
            while len(running) < workers and time.monotonic() < deadline:
                task = next(left, None)
                if task is None:
                    break
                running.add(pool.submit(judged, task))
            if not running:
                return
            patience = max(deadline + GRACE - time.monotonic(), 0.0)
            done, running = wait(running, min(patience, 3600.0), FIRST_COMPLETED)
            if not done and time.monotonic() >= deadline + GRACE:
                for process in multiprocessing.active_children():
                    process.kill()
                return
            yield from (future.result() for future in done)


def _bar(console: Console) -> Progress:
    words = TextColumn("{task.description}")
    return Progress(
        words, BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn(), console=console
    )


def prove(tasks: list[Task], workers: int, seconds: float, console: Console) -> list[dict[str, Any]]:
    """Marks of the tasks that are done, those from before included.

    Raises ProofError where a worker read other code than this process.
    """
    kept = {task.name: known_marks(task) for task in tasks}
    marks = {name: one for name, one in kept.items() if one is not None}
    todo = [task for task in tasks if task.name not in marks]
    with _bar(console) as bar:
        shown = bar.add_task("concealed cases", total=len(tasks), completed=len(marks))
        for one in _running(todo, workers, time.monotonic() + seconds):
            if one["code"] != marks_code():
                raise ProofError("the code changed while the proof ran: run it where nobody edits, or again")
            marks[one["name"]] = one
            bar.update(shown, advance=1, description=f"{one['name']:18}")
    return [marks[task.name] for task in tasks if task.name in marks]


def _about(cases: list[dict[str, Any]]) -> str:
    done = [c for c in cases if "not_drawn" not in c]
    clean = sum(c["kind"] in CLEAN for c in done)
    planned = [sum(map(len, group.values())) for group in (CONCEALED, CLEAN)]
    kinds = ", ".join(f"{sum(c['kind'] == k for c in done)} {k}" for k in {**CONCEALED, **CLEAN})
    return (
        f"{len(done) - clean} of {planned[0]} concealed cases and {clean} of {planned[1]} clean arms ran "
        f"({kinds}); code {marks_code()}. In brackets: 95 % intervals (Wilson; bootstrap over cases for F1, "
        "means and percentiles)."
    )


def _kept(path: Path) -> Any:
    return json.loads(path.read_text()) if path.exists() else None


def beside(output: Path) -> Beside:
    """The paper's table, and what `live_proof`, the killing of recorders and the chaos left in the folder."""
    kept = [_kept(output / f"{name}.json") for name in ("live", "kill", "chaos")]
    return Beside(kept[0] or [], paper_rows(), *kept[1:])


def write(cases: list[dict[str, Any]], output: Path, more: Beside) -> str:
    """Writes results.json, table.md and the figures; gives the table."""
    found = evidence(cases)
    table = as_markdown(found, cases, _about(cases), more)
    results = {
        "schema": "trunk_ros/proof/1",
        "code": marks_code(),
        "seeds": _seeds(),
        **as_json(found),
        "live": {"arms": more.live, **as_json(live(more.live))},
        "paper": [asdict(row) for row in more.paper],
        "kill": more.kill,
        "chaos": more.chaos,
        "cases": cases,
    }
    (output / "results.json").write_text(json.dumps(results, indent=1))
    (output / "table.md").write_text(table)
    done = [c for c in cases if "not_drawn" not in c]
    draw_figures(found, shares_by_way(done), output)
    draw_comparisons(found, more.live, output)
    return table


def _seeds() -> dict[str, list[int]]:
    return {kind: [some.start, some.stop] for kind, some in {**CONCEALED, **CLEAN}.items()}


def _apart(output: Path, console: Console) -> None:
    """The live graph, the killed recorders and the arm in chaos, each as its own command; what is done is not
    done again.
    """
    steps: list[tuple[Any, ...]] = [("test.concealed.live_proof", "--output", output)]
    if not (output / "kill.json").exists():
        steps.append(("test.recording.kill", "--times", 100, "--output", output / "kill.json"))
    if not (output / "chaos.json").exists():
        steps.append(("test.nodes.chaos", "--seconds", 600, "--output", output))
    for step in steps:
        console.print(" ".join(map(str, step)))
        subprocess.run([sys.executable, "-m", *map(str, step)], cwd=ROOT, check=False, stdout=sys.stderr)


def _cases(asked: argparse.Namespace, console: Console) -> list[dict[str, Any]]:
    for left in ("open", "sealed", "answers"):  # of a round that was stopped
        shutil.rmtree(asked.output / left, ignore_errors=True)
    order = in_turn(asked.full, asked.kinds)[asked.after :][: asked.cases]
    tasks = [Task(kind, seed, asked.output) for kind, seed in order]
    usual = float("inf") if asked.full else PART_SECONDS
    seconds = usual if asked.seconds is None else asked.seconds
    return prove(tasks, asked.workers, seconds, console)


def main(argv: list[str] | None = None) -> int:
    """0 when the files are written, 1 where no case could be done, 130 when stopped by hand."""
    asked = parser().parse_args(argv)
    console = Console(stderr=True)
    if asked.page:
        update_page(asked.output, ROOT / "docs")
        return 0
    for name in THREADS:
        os.environ.setdefault(name, "1")
    asked.output.mkdir(parents=True, exist_ok=True)
    try:
        cases = _cases(asked, console)
        if asked.full and asked.cases is None and not asked.kinds:
            _apart(asked.output, console)
    except ProofError as error:
        console.print(str(error))
        return 1
    except KeyboardInterrupt:
        console.print("stopped; the same command goes on where this ended")
        return 130
    if not cases:
        console.print("no case was done in the time given")
        return 1
    print(write(cases, asked.output, beside(asked.output)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
