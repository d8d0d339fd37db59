"""Columns side by side, and each by itself again, piece by piece: rows that are written across all of memory
take three times as long.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.machine import PIECE


def abreast(columns: Sequence[Array]) -> Array:
    """(n, k) of columns (n, 1)."""
    first = columns[0]
    if all(column is first for column in columns):
        return np.repeat(first, len(columns), axis=1)
    out = np.empty((len(first), len(columns)))
    for start in range(0, len(first), PIECE):
        rows = slice(start, start + PIECE)
        np.concatenate([column[rows] for column in columns], axis=1, out=out[rows])
    return out


def columns_of(columns: Array) -> list[Array]:
    """The columns (n,) of (n, k), each contiguous."""
    out = np.empty(columns.shape[::-1])
    for start in range(0, len(columns), PIECE):
        rows = slice(start, start + PIECE)
        out[:, rows] = columns[rows].T
    return list(out)
