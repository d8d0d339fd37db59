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


def finer(stamp: Floats, times: int) -> Floats:
    """(m,) s: so many stamps, evenly, from each of (n,) to the next, and the last."""
    share = np.arange(times) / times
    return np.append((stamp[:-1, None] + np.diff(stamp)[:, None] * share).ravel(), stamp[-1])


def between(stamp: Floats, values: Floats, step: float) -> tuple[Floats, Floats]:
    """Stamps (m,) s about ``step`` apart, those of ``stamp`` (n,) among them, and (m, joints) what each holds
    until the next of values that move smoothly; of equal stamps the last counts.
    """
    from scipy.interpolate import PchipInterpolator  # importing it takes a node 0.3 s

    new = np.diff(stamp, append=np.inf) > 0.0
    stamp, values = stamp[new], values[new]
    if len(stamp) < 2:
        return stamp, values
    times = max(round(float(np.median(np.diff(stamp))) / step), 1)
    fine = finer(stamp, times)
    middle = fine + np.diff(fine, append=fine[-1:]) / 2
    return fine, np.asarray(PchipInterpolator(stamp, fill(values))(middle))


def hold(values: Floats) -> Floats:
    """(n, joints) with missing values held from the last one known, the first from the next."""
    known = np.isfinite(values)
    if known.all():
        return np.ascontiguousarray(values)
    last = np.maximum.accumulate(np.where(known, np.arange(len(values))[:, None], -1), axis=0)
    first = np.where(known.any(axis=0), known.argmax(axis=0), 0)
    return np.nan_to_num(np.take_along_axis(values, np.where(last < 0, first, last), axis=0))
