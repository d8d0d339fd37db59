"""Memory that is freed and asked for again with every prediction."""

from __future__ import annotations

import ctypes
import mmap
import os
import re
from contextlib import suppress

RETURNED = 2**22  # bytes: less than one joint of two hours has
MAPPING = re.compile(rb"^(?:([0-9a-f]+)-([0-9a-f]+) (.*)|Anonymous: +0 kB)$", re.MULTILINE)


def keep_what_is_freed() -> None:
    """Let glibc keep freed arrays for the next ones: pages that go back to the system and come again take a
    twentieth of a diagnosis (mallopt(3)). What is larger than ``RETURNED`` goes back at once: kept, arrays
    of a long recording lie in each other's way, and take half as much again as is in use.
    Elsewhere nothing happens.
    """
    if os.name == "posix":
        with suppress(AttributeError, OSError):
            mallopt = ctypes.CDLL(None).mallopt
            mallopt(-3, RETURNED)  # M_MMAP_THRESHOLD
            mallopt(-1, 8 * RETURNED)  # M_TRIM_THRESHOLD: what stays at the end of the heap


def give_back(libraries: bool = False) -> None:
    """Have glibc give freed pages back to the system (malloc_trim(3)), where another part of a diagnosis
    begins that needs other arrays. ``libraries``: theirs as well (madvise(2)), in 15 ms: of 150 MiB that
    were read to load and link them a diagnosis needs 25, which come again from the system's cache. Elsewhere
    nothing happens.
    """
    if os.name == "posix":
        with suppress(AttributeError, OSError):
            libc = ctypes.CDLL(None)
            libc.malloc_trim(0)
            for begin, size in _as_on_disk() if libraries else ():
                libc.madvise(ctypes.c_void_p(begin), ctypes.c_size_t(size), mmap.MADV_DONTNEED)


def _as_on_disk() -> list[tuple[int, int]]:
    """Where memory is as it is in the file of a library, and of which size: nothing was written there, as by
    a linker or a debugger, that would be lost (proc_pid_smaps(5)).
    """
    found, begin, end = [], 0, 0
    with open("/proc/self/smaps", "rb") as mapped:
        for start, stop, words in MAPPING.findall(mapped.read()):
            if start:
                reads = words[:5] in (b"r-xp ", b"r--p ") and b" /" in words
                begin, end = (int(start, 16), int(stop, 16)) if reads else (0, 0)
            elif end:
                found.append((begin, end - begin))
    return found
