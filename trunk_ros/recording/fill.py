"""Missing values."""

from __future__ import annotations

import numpy as np

from trunk_ros.recording.recording import Floats


def fill(values: Floats) -> Floats:
    """(n, joints) with missing values held from the last one known."""
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
