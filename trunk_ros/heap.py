"""Memory that is freed and asked for again with every prediction."""

from __future__ import annotations

import ctypes
import os
from contextlib import suppress

RETURNED = 2**22  # bytes: less than one joint of two hours has


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


def give_back() -> None:
    """Have glibc give freed pages back to the system (malloc_trim(3)), where another part of a diagnosis
    begins that needs other arrays. Elsewhere nothing happens.
    """
    if os.name == "posix":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).malloc_trim(0)
