"""Setpoints that have a servo be where it should be in time, and cross a dead band faster than it would."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.servo.loop import STEP, servo_loop

QUICKER = 2.0  # times the servo's own pace: setpoints then run ahead by up to its square of what they would


class Lead:
    """The servo's equations run backward behind a filter of second order.

    The motors go over to where they are wanted as m'' = w^2 (wanted - m) - 2 w m', critically damped; the
    setpoint for that is m + (m' + tau_v m'')/Kp. m is where the servo stands by these equations under the
    setpoints that really went out: what a limit held back is caught up with, not overshot.
    """

    def __init__(self, at: Array, gain: Array, tau_v: float | Array, top_speed: float):
        """``at`` (joints,) rad: where the motors stand; the servo as in `use`."""
        still = np.zeros_like(at)
        self._wanted, self._servo = at, np.array([at, still, at])
        self.use(gain, tau_v, top_speed)

    def use(self, gain: Array, tau_v: float | Array, top_speed: float) -> None:
        """``gain`` (joints,) 1/s of the position loop, ``tau_v`` s, ``top_speed`` rad/s of the servo."""
        self.gain, self.tau_v = gain, tau_v
        self.pace = QUICKER * np.sqrt(gain / tau_v)
        none, row = np.zeros_like(gain), np.zeros((1, len(gain)))
        self._law = gain, none + tau_v, none + top_speed, none, row, none, none, row, np.zeros((3, len(gain)))

    def ahead(self, velocity: Array, acceleration: Array, dt: float) -> Array:
        """How far a reference with these derivatives (joints,) has to run ahead for the filter, which hears
        of it a period ``dt`` late.
        """
        late = 2.0 / self.pace + dt
        return late * velocity + (late**2 - 2.0 / self.pace**2) / 2.0 * acceleration

    def setpoint(self, wanted: Array, dt: float) -> Array:
        """What brings the motors to where they are ``wanted`` (joints,) rad; it holds for ``dt`` s."""
        if dt == 0.0:
            return wanted
        slope, w = (wanted - self._wanted) / dt, self.pace
        later = max(dt - STEP, 0.0) / 2.0  # the middle of it; the loop's own steps are half a step early
        stands, moves, _ = self._servo
        lag = stands - self._wanted + 2.0 * slope / w
        gains = moves - slope + w * lag
        left = np.exp(-w * later)
        goal = self._wanted + slope * later
        at = goal - 2.0 * slope / w + (lag + gains * later) * left
        speed = slope + (moves - slope - w * gains * later) * left
        acceleration = w**2 * (goal - at) - 2.0 * w * speed
        self._wanted = wanted
        return np.asarray(at + (speed + self.tau_v * acceleration) / self.gain)

    def went(self, setpoint: Array, dt: float) -> None:
        """What went out for ``dt`` s."""
        times = np.array([0.0, dt])
        servo_loop(
            np.array([setpoint, setpoint]), times, *self._law, 1, self._servo, np.empty((1, len(setpoint)))
        )
