"""From recordings to a fleet: diagnose each, follow each arm's own effects, look at all together, show."""

from __future__ import annotations

import hashlib
import json
import math
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from trunk_ros.console.console import Level, asked
from trunk_ros.console.progress import EVERY, every, spoken
from trunk_ros.diagnosis.servos.nominal_servo import Servos
from trunk_ros.fleet.inputs.listing import Job
from trunk_ros.fleet.run.cluster import each
from trunk_ros.fleet.run.examine import examine
from trunk_ros.fleet.run.follow import follow
from trunk_ros.fleet.run.loop import Plan, run
from trunk_ros.fleet.run.outcome import ERRORS, FINDINGS, Row
from trunk_ros.fleet.run.servos import servos
from trunk_ros.fleet.run.store import Store, flat, rows, write
from trunk_ros.fleet.together.arm_effects import Followed, followed, of_all, places
from trunk_ros.fleet.together.events import alone, events
from trunk_ros.fleet.together.series import collected, travels_of
from trunk_ros.fleet.together.summary import Fleet, Limits, summarised
from trunk_ros.model import Model

ARMS = "arms"
VALUES = FINDINGS[:-1]
Tick = Callable[[], None]


class Work:
    """One run of the command over the recordings of a fleet."""

    def __init__(self, folder: Path, jobs: list[Job], model: Model, client: Any, again: bool):
        """``again``: what failed before is tried once more."""
        self.folder, self.jobs, self.model, self.client, self.again = folder, jobs, model, client, again
        self.hash = model.hash()
        self.servos: dict[str, Servos] = {}
        self._shown: dict[str, float] = {}

    def run(self, limits: Limits) -> Fleet:
        """Everything; files are written even where the run is stopped half-way."""
        self.servos = servos(self.client, self.folder, self.jobs, self.model, shown)
        examined = self._examined()
        followed = self._followed(examined)
        self._reported(examined)
        fleet = together(examined, followed, limits)
        self._write(fleet)
        return fleet

    def _examined(self) -> pa.Table:
        store = Store(self.folder, "recordings")
        newest = self._newest()
        plan = Plan(
            examine,
            lambda job: self._task(job, math.isnan(job.time) or job in newest),
            lambda job: self._setting(job.arm),
            self.again,
        )
        try:
            with shown("diagnosed", len(self.jobs)) as tick:
                run(self.client, self.jobs, plan, store, tick, self._keep)
        finally:
            table = store.close()
            write(flat(table, "findings", FINDINGS), self.folder / "findings.parquet")
            write(flat(table, "errors", ERRORS), self.folder / "errors.parquet")
        return table

    def _task(self, job: Job, report: bool) -> tuple[Any, ...]:
        return job.path, self.model, report, self.servos.get(job.arm)

    def _setting(self, arm: str) -> str:
        """What results depend on besides the recording and what is followed in it."""
        found = self.servos.get(arm)
        return self.hash if found is None else f"{self.hash} {found.hash()}"

    def _newest(self) -> set[Job]:
        """The last recording of each arm, whose report is kept."""
        last: dict[str, Job] = {}
        for job in self.jobs:
            if not math.isnan(job.time) and (job.arm not in last or job.time >= last[job.arm].time):
                last[job.arm] = job
        return set(last.values())

    def _keep(self, job: Job, row: Row, files: dict[str, str]) -> None:
        """The files of a diagnosis, in the folder of its arm, where it is the arm's newest so far."""
        when = row.get("time", 0.0) if math.isnan(job.time) else job.time
        if not files or when < self._shown.get(job.arm, -math.inf):
            return
        self._shown[job.arm] = when
        folder = self.folder / ARMS / folder_of(job.arm)
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")

    def _reported(self, examined: pa.Table) -> None:
        """A report for each arm that has none, as where its newest recording could not be diagnosed."""
        good = examined.filter(pc.equal(examined["reason"], "")).select(["arm", "time", "path"]).to_pylist()
        newest = {row["arm"]: row for row in sorted(good, key=lambda row: (row["time"], row["path"]))}
        mine = {job.path: job for job in self.jobs}
        bare = [
            mine[row["path"]]
            for arm, row in newest.items()
            if row["path"] in mine and not (self.folder / ARMS / folder_of(arm)).exists()
        ]
        for job, result in each(self.client, examine, ((job, self._task(job, True)) for job in bare)):
            if isinstance(result, tuple):
                self._keep(job, *result)

    def _followed(self, examined: pa.Table) -> pa.Table:
        """Values of each arm's effects in each of its recordings."""
        good = examined.filter(pc.equal(examined["reason"], ""))
        counts = Counter(good["arm"].to_pylist())
        inside = ("word", "form", "equivalents")
        found = of_all(rows(flat(good, "findings", (*FINDINGS, *inside))), dict(counts))
        effects = {arm: given for arm, claims in found.items() if (given := followed(claims))}
        store = Store(self.folder, "followed")
        readable = set(good["path"].to_pylist())
        jobs = [job for job in self.jobs if job.path in readable and job.arm in effects]
        settings = {arm: f"{self._setting(arm)} {_hash(given)}" for arm, given in effects.items()}
        plan = Plan(
            follow,
            lambda job: (job.path, self.model, effects[job.arm], self.servos.get(job.arm)),
            lambda job: settings[job.arm],
            self.again,
        )
        try:
            with shown("followed", len(jobs)) as tick:
                run(self.client, jobs, plan, store, tick)
        finally:
            table = store.close()
        pairs = zip(table["arm"].to_pylist(), table["setting"].to_pylist(), strict=True)
        current = table.filter(pa.array([settings.get(arm) == told for arm, told in pairs], pa.bool_()))
        write(flat(current, "findings", VALUES), self.folder / "values.parquet")
        return current

    def _write(self, fleet: Fleet) -> None:
        from trunk_ros.fleet.report.page import render

        told = fleet.to_json()
        (self.folder / "fleet.json").write_text(json.dumps(told, indent=1, allow_nan=False) + "\n")
        reports = {arm: f"{ARMS}/{folder_of(arm)}/report.html" for arm in fleet.arms}
        there = {arm: link for arm, link in reports.items() if (self.folder / link).exists()}
        (self.folder / "fleet.html").write_text(render(fleet, there, self.model.hash()), encoding="utf-8")


def together(examined: pa.Table, followed: pa.Table, limits: Limits | None = None) -> Fleet:
    """What all recordings say. ``examined``, ``followed``: the tables of the two tasks."""
    good = examined.filter(pc.equal(examined["reason"], ""))
    bad = examined.filter(pc.not_equal(examined["reason"], ""))
    counts: dict[str, int] = dict.fromkeys(sorted(set(examined["arm"].to_pylist())), 0)
    counts |= Counter(good["arm"].to_pylist())
    columns = (*FINDINGS, "form")
    entries = [row for row in rows(flat(good, "findings", columns)) if row["stage"] == "arm"]
    values = [*rows(flat(followed, "findings", columns)), *entries]
    series = collected(values, travels_of(rows(good.select(["arm", "time", "path", "travel"]))))
    unread = bad.select(["path", "reason"]).to_pylist()
    fleet = summarised(series, counts, unread, limits)
    findings = rows(flat(good, "findings", columns))
    fleet.alone.update(alone(findings))
    fleet.changes.extend(events(findings, len(flat(good, "errors", ("joint",)))))
    return fleet


@contextmanager
def shown(what: str, count: int) -> Iterator[Tick]:
    """A bar with the time that is expected, on standard error, or a line every ten seconds where that is no
    terminal; yields a function that moves it on.
    """
    if asked() == Level.QUIET:
        yield lambda: None
        return
    if not sys.stderr.isatty():
        counted = _Counted(what, count)
        with every(EVERY, counted.line):
            yield counted.tick
        return
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
        TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), disable=not count) as progress:
        task = progress.add_task(what, total=count)
        yield lambda: progress.advance(task)


class _Counted:
    """How many of a kind are done, and since when."""

    def __init__(self, what: str, count: int):
        self.what, self.count, self.done, self.began = what, count, 0, time.monotonic()

    def tick(self) -> None:
        """One more."""
        self.done += 1

    def line(self) -> str:
        """All of it."""
        return f"{self.what}: {self.done} of {self.count} ({spoken(time.monotonic() - self.began)})"


def folder_of(arm: str) -> str:
    """A folder name for an arm, and no two arms in one."""
    plain = re.sub(r"[^A-Za-z0-9._-]", "_", arm).strip(".")[:60]
    return plain if plain == arm else f"{plain}-{hashlib.sha256(arm.encode()).hexdigest()[:6]}"


def _hash(effects: Followed) -> str:
    return hashlib.sha256(json.dumps(places(effects), sort_keys=True).encode()).hexdigest()[:12]
