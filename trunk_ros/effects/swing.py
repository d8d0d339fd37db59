"""How a link swings on its own: what set it going before the recording, knocked it at a stop, or moved it
while nobody saw its motor, is not known.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.guards import ROUNDED

STANDS = 0.03  # of its range: a gearbox that keeps within this stands
AT_LEAST = 0.5  # s
TURN = np.pi  # rad of its swing: a motor that was unseen for less hardly sets a link going
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


class Swings(NamedTuple):
    """Moments (k,) s from which on a link may swing freely, each until the next: by then what is left is one
    more way to swing from that. With its frequencies (k,) rad/s and damping ratios (k,) there.
    """

    moments: Array
    omega: Array
    zeta: Array

    @property
    def most(self) -> Array:
        """(k,) rad: no limit."""
        return np.full(len(self.moments), np.inf)

    def ways(self, stamp: Array) -> Array:
        """(n, 2): the two ways to swing, at ``stamp`` (n,) s."""
        out = np.zeros((len(stamp), 2))
        _swing(stamp, self.moments, self.omega, self.zeta, out)
        return out


class Decays(NamedTuple):
    """What went before the first sample and still dies away: with time constants (1 or 2,) s, and by no more
    than ``most`` rad.
    """

    moments: Array
    constants: Array
    most: Array

    def ways(self, stamp: Array) -> Array:
        """(n, 2): how each dies away, at ``stamp`` (n,) s; 0 of one that there is not."""
        out = np.zeros((len(stamp), 2))
        since = np.maximum(stamp - self.moments[0], 0.0)
        for k, constant in enumerate(self.constants):
            out[:, k] = np.exp(-since / constant)
        return out


Transients = Swings | Decays


def seen_again(unseen: Array, omega: float) -> Array:
    """(k,) s: when motors were seen again that nobody saw (m, 2) s for long enough to set a link going that
    swings with ``omega`` rad/s.
    """
    return np.asarray(unseen[(unseen[:, 1] - unseen[:, 0]) * omega > TURN, 1])


@compiled
def _swing(stamp: Array, moments: Array, omega: Array, zeta: Array, out: Array) -> None:
    last = -1
    for k in range(len(stamp)):
        while last + 1 < len(moments) and stamp[k] >= moments[last + 1]:
            last += 1
        if last >= 0:
            since, dies = stamp[k] - moments[last], min(zeta[last], 1.0)
            envelope = np.exp(-dies * omega[last] * since)
            if envelope < ROUNDED:  # it has died away
                continue
            turned = omega[last] * np.sqrt(1.0 - dies * dies) * since
            out[k, 0], out[k, 1] = envelope * np.cos(turned), envelope * np.sin(turned)
