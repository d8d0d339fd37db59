"""Slow feedback from measured joints: takes away what no model knows of, such as an offset that drifts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.trajectory import Array

RELEASE = 2.0  # tolerances that a reference has to move for the correction to be free to turn again


@dataclass(frozen=True)
class Settings:
    """``gain`` 1/s, 0 switches it off; ``rate`` rad/s of the correction; ``limit`` and ``tolerance`` rad."""

    gain: float
    rate: float
    limit: float
    tolerance: float


class SlowFeedback:
    """An integral per joint, bounded in size and rate, that rests while the error is within the tolerance.

    While the reference rests as well, the correction turns round once at most: a dead band that the model
    has too wide would else be crossed to and fro for ever.
    """

    def __init__(self, joints: int):
        self.trim = np.zeros(joints)
        self._working = np.zeros(joints, dtype=bool)
        self._side = np.zeros(joints)
        self._turned = np.zeros(joints, dtype=bool)
        self._rest: Array | None = None

    def step(self, settings: Settings, reference: Array, error: Array | None, idle: Any, dt: float) -> Array:
        """The correction (joints,) rad of the reference, ``dt`` s after the last one.

        ``error``: reference less measured angle (joints,) rad, None or NaN where nothing fresh is measured:
        there the correction stays. ``idle``: joints that must not learn, as they move or are at a limit.
        """
        self._release(reference, RELEASE * settings.tolerance)
        most = settings.rate * dt
        if settings.gain <= 0:
            self.trim = self.trim - np.clip(self.trim, -most, most)
        elif error is not None:
            change = self._change(settings.tolerance, np.clip(settings.gain * error * dt, -most, most), error)
            self.trim = np.clip(
                self.trim + np.where(self._allowed(change, idle), change, 0.0),
                -settings.limit,
                settings.limit,
            )
        return self.trim

    def _change(self, tolerance: float, change: Array, error: Array) -> Array:
        """The change without joints that are near enough, or not measured."""
        size = np.abs(error)
        self._working = np.where(self._working, size > tolerance / 2, size > tolerance)
        return np.where(self._working, change, 0.0)

    def _allowed(self, change: Array, idle: Any) -> Any:
        """Which joints may be corrected: idle ones not, nor those that would turn round a second time."""
        turns = change * self._side < 0
        allowed = ~idle & ~(turns & self._turned)
        self._turned |= turns & allowed
        self._side = np.where(allowed & (change != 0), np.sign(change), self._side)
        return allowed

    def _release(self, reference: Array, far: float) -> None:
        """A reference that has moved on lets the correction turn again."""
        if self._rest is None:
            self._rest = reference
        moved = np.abs(reference - self._rest) > far
        self._turned &= ~moved
        self._rest = np.where(moved, reference, self._rest)
