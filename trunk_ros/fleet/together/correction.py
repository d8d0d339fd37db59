"""What stands after correction for the number of things looked at (Holm 1979)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

ALPHA = 1e-3  # chance that a fleet in which nothing changes is said to hold any change at all


def stands(chances: Sequence[float], alpha: float = ALPHA) -> np.ndarray:
    """(k,) which of the chances are so small that the family of all of them errs with ``alpha`` at most."""
    p = np.asarray(chances, dtype=float)
    order = np.argsort(p, kind="stable")
    passed = p[order] <= alpha / np.arange(len(p), 0, -1)
    first = int(np.argmin(passed)) if not passed.all() else len(p)
    out = np.zeros(len(p), dtype=bool)
    out[order[:first]] = True
    return out
