"""A ROS domain for each test, and nothing of it left in shared memory: also where many tests run at once."""

from __future__ import annotations

import fcntl
import itertools
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

FIRST, COUNT = 10, 92  # above 101 are ports that Linux gives to outgoing connections
NEXT = itertools.count(31 * os.getpid())  # far from where others began
SHARED_MEMORY = Path("/dev/shm")


@contextmanager
def own_domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID that no other test on this machine uses until this one has ended."""
    before = {path.name for path in segments()}
    domain, lock = lock_domain()
    try:
        yield domain
    finally:
        clean_shared_memory(before)
        os.close(lock)


def lock_domain() -> tuple[int, int]:
    """A domain and the open file that locks it as long as this process lives.

    Raises RuntimeError where all are taken.
    """
    for number in itertools.islice(NEXT, COUNT):
        domain = FIRST + number % COUNT
        lock = os.open(Path(tempfile.gettempdir(), f"trunk_ros_domain_{domain}"), os.O_CREAT | os.O_RDWR)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(lock)
            continue
        return domain, lock
    raise RuntimeError(f"all ROS domains from {FIRST} to {FIRST + COUNT - 1} are taken by other tests")


def clean_shared_memory(before: set[str]) -> None:
    """Remove Fast DDS segments that killed processes left: new ones that no process has open or mapped."""
    new = [path for path in segments() if path.name not in before]
    used = in_use() if new else ""
    for path in new:
        segment = path.name.removeprefix("sem.").removesuffix("_mutex").removesuffix("_el")  # that it guards
        if segment not in used:
            path.unlink(missing_ok=True)


def in_use() -> str:
    """Files that processes have open or mapped. First the open ones: a file is opened, then mapped."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            for link in (process / "fd").iterdir():
                with suppress(OSError):
                    found.append(os.readlink(link))
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            found.append((process / "maps").read_text())
    return "\n".join(found)


def segments() -> list[Path]:
    """Fast DDS' files in shared memory."""
    return [*SHARED_MEMORY.glob("fastrtps_*"), *SHARED_MEMORY.glob("sem.fastrtps_*")]
