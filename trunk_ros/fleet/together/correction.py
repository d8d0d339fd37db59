"""What stands after correction for the number of things looked at (Benjamini and Hochberg 1995)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import false_discovery_control

ALPHA = 5e-3  # share of false ones among what is said; also the chance that a fleet without any shows one


def stands(chances: Sequence[float], alpha: float = ALPHA) -> np.ndarray:
    """(k,) which of the chances are so small that of all that are kept ``alpha`` at most is false."""
    if not len(chances):
        return np.zeros(0, dtype=bool)
    return np.asarray(false_discovery_control(np.clip(chances, 0.0, 1.0)) <= alpha)
