"""Memory that is freed and asked for again with every prediction."""

from __future__ import annotations

import ctypes
import os
from contextlib import suppress

import numpy as np

LEARNT = 2**25 - 2**13  # bytes: the most that glibc will learn from, its own header included


def keep_what_is_freed() -> None:
    """Let glibc keep freed arrays for the next ones: pages that go back to the system and come again take a
    twentieth of a diagnosis. It learns from the largest array that it has seen freed (mallopt(3),
    M_MMAP_THRESHOLD). Elsewhere nothing happens; no page of the array is touched.
    """
    np.empty(LEARNT, dtype=np.uint8)


def give_back() -> None:
    """Have glibc give freed pages back to the system (malloc_trim(3)), where another part of a diagnosis
    begins that needs other arrays. Elsewhere nothing happens.
    """
    if os.name == "posix":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).malloc_trim(0)
