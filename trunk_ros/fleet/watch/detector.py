"""Sequential tests side by side, by e-values (Shin, Ramdas and Rinaldo 2024).

Each test sees one number after the other. While its mean stays within its usual range, exp(λ(x - range) -
λ²s²/2) has an expectation of one at most, and so has the product of any stretch of them: the greatest product
that ends now (CUSUM) passes 1/α no more often than once in 1/α numbers in the mean. No length is fixed
beforehand, and a mixture over λ asks for no size either.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from trunk_ros.compiled import Array

Flags: TypeAlias = np.ndarray
LEARNT = 40  # numbers that tell what is usual
TOLD = 3.0  # standard errors that the usual mean may be off
WIDER = 1.3  # than what was seen: a spread from few numbers, and its tails
RATES = np.array([0.5, 1.5, 4.0])  # λ in spreads; sizes of change from 0.5 to 8 spreads are found soon
SIDES = np.array([1.0, -1.0])


class Detector:
    """m tests. All arrays are (m,) unless said otherwise; memory does not grow with time."""

    def __init__(self, tests: int, alpha: float, tolerated: float, least: Array | float):
        """``alpha``: of each test and number. ``tolerated``: change of the mean that is usual still.
        ``least``: spread that the numbers have at least.
        """
        self.bound = -float(np.log(alpha))
        self.tolerated, self.least = tolerated, np.broadcast_to(np.asarray(least, dtype=float), tests)
        self.count = np.zeros(tests, dtype=int)
        self.mean, self._squares = np.zeros(tests), np.zeros(tests)
        self.evidence = np.zeros((tests, len(SIDES), len(RATES)))
        """Logarithms of the e-values."""
        self.since = np.full((tests, len(SIDES), len(RATES)), np.nan)
        """When each began to grow [s]."""

    @property
    def learnt(self) -> Flags:
        """Which tests know what is usual."""
        return np.asarray(self.count >= LEARNT)

    @property
    def spread(self) -> Array:
        """Of the numbers, widened."""
        seen = np.sqrt(self._squares / np.maximum(self.count - 1, 1))
        return np.asarray(np.maximum(WIDER * seen, self.least))

    def forget(self, tests: Flags) -> None:
        """Learn anew what is usual."""
        self.count[tests] = 0
        self.mean[tests] = self._squares[tests] = 0.0
        self.evidence[tests] = 0.0

    def update(self, number: Array, ready: Flags, begun: Array) -> Flags:
        """One more number of each test that is ``ready``, of data since ``begun`` [s]; which ones pass."""
        learning = ready & ~self.learnt
        testing = ready & self.learnt
        self._learn(np.where(learning, number, 0.0), learning)
        off = np.where(testing, number - self.mean, 0.0)
        spread = self.spread
        room = self.tolerated + TOLD * spread / np.sqrt(LEARNT)
        z = (SIDES * off[:, None] - room[:, None]) / spread[:, None]
        grown = RATES * z[:, :, None] - RATES**2 / 2.0
        fresh = testing[:, None, None] & (self.evidence <= 0.0)
        self.since = np.where(fresh, begun[:, None, None], self.since)
        more = np.maximum(self.evidence, 0.0) + grown
        self.evidence = np.where(testing[:, None, None], more, self.evidence)
        return np.asarray(testing & (self.mixed() > self.bound))

    def mixed(self) -> Array:
        """Logarithm of each test's e-value over both sides and all rates."""
        top = self.evidence.max(axis=(1, 2))
        spread = np.exp(self.evidence - top[:, None, None]).mean(axis=(1, 2))
        return np.asarray(top + np.log(spread))

    def begun(self, test: int) -> float:
        """When what a test has found began [s]."""
        side, rate = np.unravel_index(int(np.argmax(self.evidence[test])), self.evidence[test].shape)
        return float(self.since[test, side, rate])

    def _learn(self, number: Array, learning: Flags) -> None:
        """Welford's mean and sum of squares."""
        self.count = self.count + learning
        step = np.where(learning, number - self.mean, 0.0)
        self.mean = self.mean + step / np.maximum(self.count, 1)
        self._squares = self._squares + step * np.where(learning, number - self.mean, 0.0)
