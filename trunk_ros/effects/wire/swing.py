"""How a link swings on its own: what set it going before the recording, or knocked it at a stop, is not
known.
"""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled

STANDS = 0.03  # of its range: a gearbox that keeps within this stands
AT_LEAST = 0.5  # s
MOST = 6  # moments: in a motion with more stops a swing is known well enough by the motion that made it


def stops(stamp: Array, position: Array) -> Array:
    """The beginning [s] and the moments at which a gearbox (n,) comes to stand; none where it never or
    often does.
    """
    within = STANDS * float(np.ptp(position))
    if within == 0.0:
        return np.empty(0)
    moments = np.union1d(stamp[:1], stamp[_rests(stamp, position, within)])
    return moments if 1 < len(moments) <= MOST else np.empty(0)


@compiled
def _rests(stamp: Array, position: Array, within: float) -> np.ndarray:
    """Rows at which stretches of at least AT_LEAST begin that keep ``within`` a range."""
    begun, noted = 0, -1
    low = high = position[0]
    out = np.zeros(len(stamp), dtype=np.bool_)
    for k in range(len(stamp)):
        low, high = min(low, position[k]), max(high, position[k])
        if high - low > within:
            low = high = position[k]
            begun = k
        elif noted != begun and stamp[k] - stamp[begun] >= AT_LEAST:
            out[begun] = True
            noted = begun
    return np.flatnonzero(out)


@compiled
def free_swings(stamp: Array, moments: Array, omega: float, zeta: float) -> Array:
    """(n, 2 moments): the two ways to swing freely from each moment on."""
    damped = omega * np.sqrt(1.0 - zeta * zeta)
    out = np.zeros((len(stamp), 2 * len(moments)))
    for i in range(len(moments)):
        for k in range(np.searchsorted(stamp, moments[i]), len(stamp)):
            since = stamp[k] - moments[i]
            envelope = np.exp(-zeta * omega * since)
            out[k, 2 * i] = envelope * np.cos(damped * since)
            out[k, 2 * i + 1] = envelope * np.sin(damped * since)
    return out
