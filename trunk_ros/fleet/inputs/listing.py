"""What the arguments of ``fleet`` name: bags, folders of bags, globs, lists, local or behind a URL."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from trunk_ros.errors import ArgumentError
from trunk_ros.fleet.inputs.files import FILES, METADATA, file_system, is_url
from trunk_ros.fleet.inputs.table import listed_in

LISTS = (".csv", ".parquet", ".pq")


@dataclass(frozen=True)
class Job:
    """One recording to diagnose. ``time`` [s since the epoch] is NaN where the recording itself is to say."""

    arm: str
    time: float
    path: str

    @property
    def recording(self) -> str:
        """Name of the bag's folder or file."""
        return PurePosixPath(self.path.rstrip("/")).name


def listed(arguments: Iterable[str]) -> list[Job]:
    """The recordings that the arguments name, each once. Raises ArgumentError where one names none."""
    jobs: dict[str, Job] = {}
    for argument in arguments:
        found = list(_of(argument))
        if not found:
            raise ArgumentError(f"{argument}: no recording there (bag folders, {', '.join(FILES)})")
        for job in found:
            jobs.setdefault(job.path, job)
    return list(jobs.values())


def _of(argument: str) -> Iterator[Job]:
    if argument.lower().endswith(LISTS):
        yield from (Job(*row) for row in listed_in(argument))
        return
    system, path = file_system(argument)
    try:
        places = sorted(system.glob(path)) if any(mark in path for mark in "*?[") else [path]
        for place in places:
            yield from _below(system, str(place), argument)
    except (OSError, ValueError) as error:
        raise ArgumentError(f"{argument}: cannot be listed ({error})") from None


def _below(system: Any, place: str, argument: str) -> Iterator[Job]:
    """The recording at a place, or those anywhere below it."""
    if not system.exists(place):
        raise ArgumentError(f"{argument}: does not exist")
    if not system.isdir(place) or system.exists(f"{place}/{METADATA}"):
        yield _job(system, place, argument)
        return
    files = [PurePosixPath(file) for file in sorted(system.find(place))]
    folders = {file.parent for file in files if file.name == METADATA}
    bare = [file for file in files if file.suffix in FILES and not folders & set(file.parents)]
    for bag in sorted([*folders, *bare]):
        yield _job(system, str(bag), argument)


def _job(system: Any, place: str, argument: str) -> Job:
    """The arm of a recording that no list names is the folder that it lies in."""
    path = str(system.unstrip_protocol(place)) if is_url(argument) else place
    return Job(PurePosixPath(place).parent.name or "arm", math.nan, path)
