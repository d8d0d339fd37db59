"""All recordings through one task: what is known is passed over, what comes is kept."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from trunk_ros.errors import one_line
from trunk_ros.fleet.inputs.files import fingerprint
from trunk_ros.fleet.inputs.listing import Job
from trunk_ros.fleet.run.cluster import Task, each
from trunk_ros.fleet.run.outcome import Row, unread
from trunk_ros.fleet.run.store import Store


@dataclass(frozen=True)
class Plan:
    """What is to be done with each recording: ``work(*arguments(job))`` gives a row and files by name.

    ``setting(job)``: what the result depends on besides the recording.
    """

    work: Callable[..., Any]
    arguments: Callable[[Job], Task]
    setting: Callable[[Job], str]
    again: bool = False
    """Try once more what failed before."""


def run(
    client: Any,
    jobs: Iterable[Job],
    plan: Plan,
    store: Store,
    tick: Callable[[], None] = lambda: None,
    keep: Callable[[Job, Row, dict[str, str]], None] = lambda *_: None,
) -> None:
    """Do what is not done. ``tick`` is called once per recording, ``keep`` with the files of each."""
    for (job, content), result in each(client, plan.work, _open(jobs, plan, store, tick)):
        row, files = result if isinstance(result, tuple) else (unread(_failure(result)), {})
        _add(store, job, row, content, plan.setting(job))
        keep(job, row, files)
        tick()


def _open(
    jobs: Iterable[Job], plan: Plan, store: Store, tick: Callable[[], None]
) -> Iterator[tuple[tuple[Job, str], Task]]:
    """What is still to be done. The same content is not diagnosed twice, under whatever path it lies."""
    for job in jobs:
        setting = plan.setting(job)
        try:
            content = fingerprint(job.path)
        except OSError as error:
            _add(store, job, unread(one_line(f"{job.path}: cannot be read ({error})")), "", setting)
            tick()
            continue
        twin = None
        if not store.done(job, content, setting, plan.again):
            twin = store.of_content(content, setting)
            if twin is None:
                yield (job, content), plan.arguments(job)
                continue
            _add(store, job, twin, content, setting)
        tick()


def _add(store: Store, job: Job, row: Row, content: str, setting: str) -> None:
    own = row.get("time", math.nan)
    when = own if math.isnan(job.time) else job.time
    which = {"arm": job.arm, "time": when, "recording": job.recording, "path": job.path}
    store.add({**row, **which, "content": content, "setting": setting})


def _failure(error: BaseException) -> str:
    if type(error).__name__ == "KilledWorker":
        return "the process that diagnosed it was killed: not enough memory, most likely"
    return one_line(f"{type(error).__name__}: {error}")
