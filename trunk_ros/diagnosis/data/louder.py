"""Noise that grows with speed, as stamps that jitter and cameras that blur make it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.data.noise import FLOOR, fourth_differences, trimmed
from trunk_ros.diagnosis.levels import CLEARLY, ENOUGH, ROUGHLY
from trunk_ros.guards import ROUNDS
from trunk_ros.recording.signal.encoder import ALTERNATES

GROUPS = 8  # of samples, by speed


@dataclass(frozen=True)
class Louder:
    """How the noise of each joint grows with its speed: ``each`` (joints,) s/rad, 0 where it does not."""

    each: tuple[float, ...] = ()

    @staticmethod
    def of(each: Sequence[float]) -> Louder:
        """Sensors are alike: what more than half of the joints show is that of the others as well."""
        known = [one for one in each if one > 0.0]
        usual = float(np.median(known)) if 2 * len(known) > len(each) else 0.0
        return Louder(tuple(one or usual for one in each))

    def at(self, speed: Array, column: int) -> Array | float:
        """Noise over that at rest, at speeds (n,) rad/s of a joint."""
        grows = self.each[column] if self.each else 0.0
        return np.asarray(np.hypot(1.0, grows * speed)) if grows else 1.0

    def evened(self, signal: Array, speed: Array, column: int, burst: Array | None = None) -> Array:
        """A signal (n,) of a joint in the measure of its noise at rest; a ``burst`` (n,) is so many times as
        loud.
        """
        loud = self.at(speed, column)
        even = signal if isinstance(loud, float) else signal / loud
        return even if burst is None else even / burst


CONSTANT = Louder()


def growth(residuals: Sequence[Array], speeds: Sequence[Array], masks: Sequence[np.ndarray]) -> float:
    """k [s/rad] of noise whose standard deviation goes with sqrt(1 + (k speed)^2); 0 where it is the same at
    every speed, or where what grows with speed is no noise, or where readings stand between counts and show
    none at some speed.

    ``residuals`` and ``speeds`` (n,) rad/s of each recording, and where they count (n,).
    """
    found = [_differences(*each) for each in zip(residuals, speeds, masks, strict=True)]
    size, speed, turns = (np.concatenate([parts[k] for parts in found]) for k in range(3))
    if len(size) < GROUPS * ENOUGH:
        return 0.0
    group = np.argsort(np.argsort(speed, kind="stable"), kind="stable") * GROUPS // len(speed)
    each = np.array([trimmed(size[group == g]) for g in range(GROUPS)])
    fast = group >= GROUPS // 2
    if each.min() <= FLOOR or each[-1] < CLEARLY * each[0] or float(np.mean(turns[fast])) > ALTERNATES:
        return 0.0
    squares = np.array([np.mean(speed[group == g] ** 2) for g in range(GROUPS)])
    rest, rising = _line(squares, each**2)
    law = rest + rising * squares
    if rest <= 0.0 or rising <= 0.0 or np.any(np.abs(each**2 - law) > ROUGHLY * law):
        return 0.0
    return float(np.sqrt(rising / rest))


def _differences(residual: Array, speed: Array, mask: np.ndarray) -> tuple[Array, Array, Array]:
    """(k,) of fourth differences: their sizes, the speeds in their middle, and whether each has the sign of
    the next (1, -1).
    """
    difference, whole = fourth_differences(residual, mask)
    turns = np.sign(difference) * np.sign(np.append(difference[1:], 0.0))
    return np.abs(difference[whole]), np.abs(speed[2 : len(difference) + 2][whole]), turns[whole]


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Offset and slope of ``y`` (k,) over ``x`` (k,), each off in proportion to itself."""
    weight = y.copy()
    offset = slope = 0.0
    for _ in range(ROUNDS):
        basis = np.column_stack([np.ones_like(x), x]) / weight[:, None]
        offset, slope = np.linalg.lstsq(basis, y / weight, rcond=None)[0]
        weight = np.maximum(offset + slope * x, 0.1 * y)
    return float(offset), float(slope)
