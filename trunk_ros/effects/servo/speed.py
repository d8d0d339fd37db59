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
def led_on(led: float, pace: float, goal: float, most: float, ramp: float, h: float) -> tuple[float, float]:
    """Where a profile is a step after it was at ``led``, and its speed, which was ``pace``: as fast as it may
    go, at ``most``, but for what it can still brake from, by ``ramp``, until it is at the ``goal``.
    """
    way = 1.0 if goal >= led else -1.0
    off, speed, change = way * (goal - led), way * pace, ramp * h
    if off <= 0.5 * change * h and abs(speed) <= change:
        return goal, 0.0
    room = 0.25 * change**2 + ramp * (2.0 * off - h * speed)  # (speed + v) h / 2 + v^2 / (2 ramp) = off
    wanted = float(np.sqrt(room)) - 0.5 * change if room > 0.0 else 0.0
    after = towards(speed, min(max(wanted, 0.0), most), change)
    return led + 0.5 * h * (pace + way * after), way * after


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
