"""What the integral parts of a servo ask for."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.servo.asked import beyond


@compiled
def first_asked(setpoint: Array, stamp: Array, j: int, row: int, late: float) -> float:
    """The setpoint that acts where a run begins, before ``row``."""
    began = stamp[max(row - 1, 0)] - late + 1e-9
    acts: float = setpoint[max(np.searchsorted(stamp, began, side="right") - 1, 0), j]
    return acts


@compiled
def held_at_first(
    error: float,
    tension: float,
    past: float,
    v: float,
    gain: float,
    zone: float,
    least: float,
    most: float,
) -> float:
    """rad/s that an integral part asks for where a run begins: what the loop does not of the shaft's speed
    ``v``; ``error`` is that without ``tension``, which pulls.
    """
    asked = gain * beyond(error + (1.0 - past) * tension, zone)
    return v - min(max(asked, least), most) - gain * past * tension


@compiled
def summed_up(total: float, more: float, asked: float, least: float, most: float) -> float:
    """No further while the loop asks for more than its top speed, or for more than may wind up beyond it."""
    winds = (asked > most and more > 0.0) or (asked < least and more < 0.0)
    return total if winds else total + more


@compiled
def gathered(own: float, change: float, most: float) -> float:
    """What the integral part of a speed's loop gathers in a step of its ``own``, while the speed changes by
    ``change``: nothing that would lead further beyond the ``most`` that it can.
    """
    return own if abs(change) < most or own * change < 0.0 else 0.0
