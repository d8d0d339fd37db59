"""The workers: one process per core here, or those of a scheduler that exists."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from typing import Any

from trunk_ros.errors import ArgumentError

TRIES = 2  # more, for what fails for reasons of the network
DEATHS = 1  # workers that a recording may take with it; then it is a row with that reason
AHEAD = 4  # tasks per thread that the scheduler holds: enough to keep all busy, however many there are

Task = tuple[Any, ...]


def needs_extra() -> None:
    """Raise ArgumentError where the packages of the extra are missing."""
    try:
        import distributed  # noqa: F401
        import pyarrow  # noqa: F401
        import ruptures  # noqa: F401
    except ImportError as error:
        raise ArgumentError(f"fleet needs {error.name}: pip install 'trunk_ros[fleet]'") from None


@contextmanager
def connected(scheduler: str | None, workers: int | None = None) -> Iterator[Any]:
    """A client of a scheduler, by default of one that lives as long as this. ArgumentError: no answer."""
    import dask
    from distributed import Client, LocalCluster

    settings = {
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.comm.timeouts.connect": "20s",
        "distributed.worker.memory.terminate": 0.95,
        "distributed.worker.profile.enabled": False,  # keeps stacks for an hour: 1 MB a recording
    }
    with dask.config.set(settings):
        if scheduler is None:
            cluster = LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )  # fmt: skip
            with cluster, Client(cluster) as client:
                yield client
            return
        try:
            client = Client(scheduler)
        except (OSError, ValueError) as error:
            raise ArgumentError(f"--scheduler {scheduler}: {error}") from None
        with client:
            yield client


def each(client: Any, work: Callable[..., Any], tasks: Iterable[tuple[Any, Task]]) -> Iterator[Any]:
    """(name, result) of each task as they end, where it failed with its exception in the result's place.

    ``tasks``: name and arguments; they are taken as there is room, so that any number fits into memory.
    """
    from distributed import as_completed

    waiting = iter(tasks)
    names: dict[Any, Any] = {}

    def begin(count: int) -> list[Any]:
        begun = []
        for name, arguments in islice(waiting, count):
            future = client.submit(work, *arguments, pure=False, retries=TRIES)
            names[future.key] = name
            begun.append(future)
        return begun

    threads = max(sum(client.nthreads().values()), 1)
    pool = as_completed(begin(AHEAD * threads))
    for future in pool:
        name = names.pop(future.key)
        yield name, _result(future)
        future.release()
        for more in begin(1):
            pool.add(more)


def _result(future: Any) -> Any:
    if future.status == "finished":
        return future.result()
    return future.exception() or RuntimeError(f"the task was {future.status}")
