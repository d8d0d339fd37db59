"""What a deviation looks like: the regime that explains most of it, and how large it is there.

Sizes are least absolute deviations: samples that are far off, as glitches of a sensor are, count like any.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.fleet.watch.regimes import REGIMES, SCATTER

EXPLAINS = 0.25  # of the mean size that the deviation has above the noise
SURE = 0.5  # of it: no longer waited for more
ALIKE = 0.85  # of what the best regime explains: those that explain as much are not told from it
SHORTEST, LONGEST = 2.0, 8.0  # s of samples after a test has passed, until the regime is said
NOISE = np.sqrt(2.0 / np.pi)  # mean size of unit noise
FAR = 4.0  # times a size that most samples are below
GLITCH = 8.0  # noise that one sample counts for at most, where it is not usual


@dataclass(frozen=True)
class Look:
    """``regime`` and ``rivals`` are columns of REGIMES; ``size`` in units of the noise, that of scatter in
    those of its power; ``share`` of the deviation that the regime explains.
    """

    regime: int
    rivals: tuple[int, ...]
    size: float
    share: float


class Usual:
    """What regimes together make of each joint's residual while it is learnt."""

    def __init__(self, joints: int):
        self._squares = np.zeros((joints, SCATTER, SCATTER))
        self._sums = np.zeros((joints, SCATTER))

    def learn(self, off: Array, weights: Array, joints: np.ndarray) -> None:
        """Samples (n, joints) with weights (n, joints, regimes) of some ``joints``."""
        for j in joints.tolist():
            own = weights[:, j]
            most = GLITCH * max(1.0, float(np.median(np.abs(off[:, j]))))
            self._squares[j] += own.T @ own
            self._sums[j] += np.clip(off[:, j], -most, most) @ own

    def forget(self, joint: int) -> None:
        """Learn a joint anew."""
        self._squares[joint] = self._sums[joint] = 0.0

    def of(self, joint: int) -> Array:
        """(regimes,), 0 of those that were never there."""
        return np.asarray(np.linalg.solve(self._squares[joint] + np.eye(SCATTER), self._sums[joint]))


@dataclass
class Alarm:
    """A joint whose test passed at ``seen`` s: what came since then, until that tells what it looks like."""

    since: float
    seen: float
    evidence: float
    usual: Array
    scatter: float
    """Power of the residual that was usual."""
    off: list[Array] = field(default_factory=list)
    weights: list[Array] = field(default_factory=list)

    def add(self, off: Array, weights: Array, valid: np.ndarray) -> None:
        """Samples (n,) with weights (n, regimes)."""
        self.weights.append(weights[valid])
        self.off.append(off[valid] - self.weights[-1] @ self.usual)

    def look(self) -> Look:
        """What they look like."""
        return looked(np.concatenate(self.off), np.concatenate(self.weights), self.scatter)

    def over(self, now: float) -> bool:
        """Whether it is to be said: its regime shows, or enough was waited for."""
        if now - self.seen < SHORTEST:
            return False
        if now - self.seen >= LONGEST:
            return True
        look = self.look()
        return not look.rivals and look.share > SURE


def looked(off: Array, weights: Array, scatter: float) -> Look:
    """The look of deviations (n,) in units of the noise, whose power was ``scatter``."""
    size = np.abs(off)
    most = GLITCH + FAR * float(np.quantile(size, 0.75)) if len(size) else GLITCH
    steps = [_step(off, weights[:, k]) for k in range(SCATTER)]
    gains = np.array([np.sum(size - np.abs(off - steps[k] * weights[:, k])) for k in range(SCATTER)])
    best = int(np.argmax(gains))
    grown = float(np.sum(np.minimum(size, most) - NOISE))
    share = float(gains[best]) / grown if grown > 0.0 else 0.0
    if share < EXPLAINS:
        power = float(np.mean(np.minimum(size, most) ** 2)) if len(size) else scatter
        return Look(SCATTER, (), power - scatter, share)
    rivals = tuple(k for k in range(SCATTER) if k != best and gains[k] > ALIKE * gains[best])
    shown = weights[:, best][weights[:, best] != 0.0]
    return Look(best, rivals, steps[best] * float(np.sqrt(np.mean(shown**2))), share)


def _step(off: Array, weight: Array) -> float:
    """By how much a deviation goes with a weight: the median of their ratios, each as sure as it is heavy."""
    there = weight != 0.0
    if not there.any():
        return 0.0
    ratio, heavy = off[there] / weight[there], np.abs(weight[there])
    order = np.argsort(ratio)
    reached = np.cumsum(heavy[order])
    return float(ratio[order][np.searchsorted(reached, 0.5 * reached[-1])])


def in_words(regime: str, rivals: tuple[str, ...]) -> str:
    """A regime, and those that it is not told from."""
    return " or ".join((regime, *rivals))


def names(columns: tuple[int, ...]) -> tuple[str, ...]:
    """Of regimes."""
    return tuple(REGIMES[k] for k in columns)
