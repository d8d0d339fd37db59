"""Noise that grows with speed, as stamps that jitter and cameras that blur make it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.noise import FLOOR, fourth_differences, off_by_chance, trimmed
from trunk_ros.guards import ROUNDS
from trunk_ros.levels import CLEARLY, ENOUGH, FEWEST, OUTLIERS, PART, ROUGHLY
from trunk_ros.recording.signal.encoder import ALTERNATES

GROUPS = 8  # of samples, by speed
IN_POWER, IN_SIZE = 2.0, 1.0
"""Powers in which the noise of motion adds to that at rest: another noise beside it, or as a share of it."""


@dataclass(frozen=True)
class Growth:
    """Noise that is (1 + (rate speed)^power)^(1/power) times that at rest; ``rate`` in s/rad."""

    rate: float = 0.0
    power: float = IN_POWER

    def at(self, speed: Array) -> Array:
        """Noise over that at rest, at speeds (n,) rad/s."""
        return np.asarray((1.0 + np.abs(self.rate * speed) ** self.power) ** (1.0 / self.power))


NONE = Growth()


@dataclass(frozen=True)
class Louder:
    """How the noise of each joint grows with its speed."""

    each: tuple[Growth, ...] = ()

    @staticmethod
    def of(each: Sequence[Growth]) -> Louder:
        """Sensors are alike: what more than half of the joints show is that of the others as well."""
        known = sorted((one for one in each if one.rate > 0.0), key=lambda one: one.rate)
        usual = known[len(known) // 2] if 2 * len(known) > len(each) else NONE
        return Louder(tuple(one if one.rate > 0.0 else usual for one in each))

    def at(self, speed: Array, column: int) -> Array | float:
        """Noise over that at rest, at speeds (n,) rad/s of a joint."""
        grows = self.each[column] if self.each else NONE
        return grows.at(speed) if grows.rate else 1.0

    def evened(
        self, signal: Array, speed: Array, column: int, burst: Array | None = None, zero: Array | None = None
    ) -> Array:
        """A signal (n,) of a joint in the measure of its noise at rest; a ``burst`` (n,) is so many times as
        loud. All but its ``zero`` (n,): a constant, divided by what goes with the speed, looks like noise.
        """
        loud = self.at(speed, column)
        if zero is None or (isinstance(loud, float) and burst is None):
            even = signal if isinstance(loud, float) else signal / loud
            return even if burst is None else even / burst
        return zero + self.evened(signal - zero, speed, column, burst)

    def but_on(self, columns: Collection[int]) -> Louder:
        """The same with noise that does not grow on some joints."""
        return Louder(tuple(NONE if c in columns else one for c, one in enumerate(self.each)))


CONSTANT = Louder()


def growth(residuals: Sequence[Array], speeds: Sequence[Array], masks: Sequence[np.ndarray]) -> Growth:
    """How noise grows with speed; NONE where it is the same at every speed, or where what grows with speed is
    no noise, or where readings stand between counts and show none at some speed.

    ``residuals`` and ``speeds`` (n,) rad/s of each recording, and where they count (n,).
    """
    found = [_differences(*each) for each in zip(residuals, speeds, masks, strict=True)]
    size, speed, turns = (np.concatenate([parts[k] for parts in found]) for k in range(3))
    if len(size) < GROUPS * ENOUGH:
        return NONE
    group = _by_speed(speed)
    each = np.array([trimmed(size[group == g]) for g in range(GROUPS)])
    fast = group >= GROUPS // 2
    if each.min() <= FLOOR or each[-1] < CLEARLY * each[0] or float(np.mean(turns[fast])) > ALTERNATES:
        return NONE
    chance = max(off_by_chance(int(count)) for count in np.bincount(group))
    laws = []
    for power in (IN_POWER, IN_SIZE):
        powers = np.array([np.mean(speed[group == g] ** power) for g in range(GROUPS)])
        rest, rising = _line(powers, each**power)
        law = np.maximum(rest + rising * powers, 0.0) ** (2.0 / power)
        if rest > 0.0 and rising > 0.0:
            off = float(np.max(np.abs(each**2 - law) / law))
            laws.append((off, Growth(float((rising / rest) ** (1.0 / power)), power)))
    off, grows = min(laws, key=lambda law: law[0], default=(np.inf, NONE))
    return grows if off <= max(ROUGHLY, chance) else NONE


def _by_speed(speed: Array) -> np.ndarray:
    """(n,) groups by speed (n,): those samples that hardly move, an equal share of all at least, and as many
    of the others in each. In equal shares of all a joint that mostly rests would move in one of them alone.
    """
    rank = np.argsort(np.argsort(speed, kind="stable"), kind="stable")
    still = int(np.count_nonzero(speed < PART * np.quantile(speed, 1.0 - OUTLIERS)))
    still = max(min(still, len(speed) - (GROUPS - 1) * FEWEST), len(speed) // GROUPS)
    moving = np.maximum(rank - still, -1)
    return np.asarray(1 + moving * (GROUPS - 1) // (len(speed) - still))


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
