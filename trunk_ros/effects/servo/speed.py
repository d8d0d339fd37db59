"""How the speed of a shaft follows what it is asked for."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import compiled
from trunk_ros.guards import ROUNDED


@compiled
def towards(now: float, wanted: float, most: float) -> float:
    """From ``now`` on to what is ``wanted``, by no more than ``most``."""
    return now + min(max(wanted - now, -most), most)


@compiled
def held_back(speed: float, most: float) -> float:
    """A speed that friction has changed by what it needs to stop it, and by no more than ``most``: friction
    of the end of a step, as of its beginning it would swing.
    """
    return speed - min(max(speed, -most), most)


@compiled
def rise(h: float, tau: float, ahead: float) -> float:
    """How much of what it is asked for a speed comes nearer to in a step, as in as many of ``1 - 2 ahead`` of
    it as go into one.
    """
    own = (1.0 - 2.0 * ahead) * h
    if ahead == 0.0 and tau >= h:
        return h / tau
    if own <= ROUNDED * h or tau <= own:
        return -float(np.expm1(-h / tau))
    return -float(np.expm1(h / own * np.log1p(-own / tau)))
