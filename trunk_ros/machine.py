"""What fits into memory and caches: no answer depends on these, only how fast it comes and what it needs."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, MutableMapping
from typing import Any, TypeVar

import numpy as np

Key = TypeVar("Key", bound=Hashable)

NUMBER = 4
"""Bytes of a number that processes hand each other."""
FORKED = 0.06
"""Processor time [s] that another process costs, measured: what it writes to is copied page by page."""
PIECE = 2048
"""Rows that stay in the processor's cache."""
CELLS = 2**17
"""Samples that are computed together, and at which what is known of the whole arm is kept: of long recordings
more would not fit into memory.
"""
FACTORS = 8
"""Sizes of which one logarithm is taken: a product of more might be no number."""
BOUND = 64
"""Blocks of one joint kept: what a fit leaves as it is is not made anew."""
FOUND = 32
"""A joint's rest that is remembered takes as much room as so many samples."""


def pieces(rows: int, columns: int = 1) -> list[slice]:
    """Rows of so many columns that are computed together; of short recordings all of them."""
    together = CELLS if rows <= CELLS else CELLS // columns
    return [slice(k, k + together) for k in range(0, max(rows, 1), together)]


def precision(rows: int) -> type[np.floating[Any]]:
    """What is kept of so many rows of much that effects or features make: of long recordings in single
    precision, which is less than any of it is known to.
    """
    return np.float64 if rows <= CELLS else np.float32


def make_room(kept: MutableMapping[Key, Any], rows: int, among: Iterable[Key]) -> None:
    """Forget the oldest ``among`` what is ``kept``, until one more of so many rows fits beside the others."""
    most = max(CELLS // rows, 1)
    if len(kept) < most:
        return
    there = list(among)
    for old in there[: max(len(there) + 1 - most, 0)]:
        del kept[old]
