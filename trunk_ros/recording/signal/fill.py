"""Missing values."""

from __future__ import annotations

import numpy as np

from trunk_ros.recording.recording import Floats


def fill(values: Floats) -> Floats:
    """(n, joints) with missing values on the way from the last known one to the next."""
    if np.isfinite(values).all():
        return np.ascontiguousarray(values)
    out = values.copy()
    for j in range(values.shape[1]):
        known = np.flatnonzero(np.isfinite(values[:, j]))
        if len(known):
            out[:, j] = np.interp(np.arange(len(values)), known, values[known, j])
        else:
            out[:, j] = 0.0
    return out


def hold(values: Floats) -> Floats:
    """(n, joints) with missing values held from the last one known, the first from the next."""
    known = np.isfinite(values)
    last = np.maximum.accumulate(np.where(known, np.arange(len(values))[:, None], -1), axis=0)
    first = np.where(known.any(axis=0), known.argmax(axis=0), 0)
    return np.nan_to_num(np.take_along_axis(values, np.where(last < 0, first, last), axis=0))
