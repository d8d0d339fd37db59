"""What all arms of a type show, which is the simulator's fault, and what is one arm's own.

Arms are drawn around a common value with a spread between them: the middle of all arms and the median of
their distances from it, so that a batch of odd arms moves neither.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from scipy import stats

from trunk_ros.compiled import Array
from trunk_ros.effects import effect
from trunk_ros.fleet.together.correction import ALPHA, stands
from trunk_ros.fleet.together.judged import COVERED, Judged

MOST = 0.8  # of the arms: what so many show is the type's
SURE = 2.0  # standard deviations that an arm's value has to be from null to show an effect
FEW = 3  # arms without which nothing can be said of all
CONSISTENT = 1.4826  # median distance to standard deviation


@dataclass(frozen=True)
class Common:
    """The value that arms of a type have in common, and how far single arms are from it."""

    effect: str
    joint: str
    parameter: str
    unit: str
    value: float
    interval: tuple[float, float]
    spread: float
    """Standard deviation between arms."""
    arms: int
    """That show it."""
    of: int


@dataclass(frozen=True)
class Own:
    """What one arm has of an effect beyond (or short of) what the others have."""

    arm: str
    effect: str
    joint: str
    parameter: str
    unit: str
    value: float
    std: float
    others: float
    chance: float


Where = tuple[str, str, str]


def common_and_own(
    found: list[Judged], arms: list[str], alpha: float = ALPHA
) -> tuple[list[Common], list[Own]]:
    """What all arms share, and what stands out on single ones, after correction for all that was compared."""
    groups: dict[Where, dict[str, Judged]] = defaultdict(dict)
    for one in found:
        key = one.series.key
        groups[key.effect, key.joint, key.parameter][key.arm] = one
    shared, own = [], []
    for where, members in groups.items():
        told = _common(where, members, len(arms))
        shared += [told] if told else []
        own += _own(where, members, len(arms), told)
    kept = stands([each.chance for each in own], alpha)
    return shared, [each for each, keep in zip(own, kept, strict=True) if keep]


def _common(where: Where, members: dict[str, Judged], arms: int) -> Common | None:
    if arms < FEW:
        return None
    null = effect(where[0]).null()[where[2]]
    level, std = _levels(members)
    side = 1.0 if np.median(level) > null else -1.0
    showing = int(np.sum(side * (level - null) > SURE * std))
    if showing < MOST * arms:
        return None
    middle = float(np.median(level))
    spread = _between(level, std, middle)
    error = float(np.sqrt(np.pi / 2.0 * np.mean(std**2 + spread**2) / len(level)))
    half = float(stats.t.ppf(0.5 + COVERED / 2, len(level) - 1)) * error
    unit = next(iter(members.values())).series.unit
    return Common(*where, unit, middle, (middle - half, middle + half), spread, showing, arms)


def _own(where: Where, members: dict[str, Judged], arms: int, shared: Common | None) -> list[Own]:
    null = effect(where[0]).null()[where[2]]
    others, spread = (shared.value, shared.spread) if shared else (null, 0.0)
    out = []
    for arm, one in members.items():
        level, std = one.level
        far = abs(level - others) / np.hypot(max(std, 1e-300), spread)
        dof = min(one.dof, float(max(arms - 1, 1))) if shared else one.dof
        chance = 2.0 * float(stats.t.sf(far, dof))
        out.append(Own(arm, *where, one.series.unit, level, std, others, chance))
    return out


def _levels(members: dict[str, Judged]) -> tuple[Array, Array]:
    pairs = np.array([one.level for one in members.values()])
    return pairs[:, 0], pairs[:, 1]


def _between(level: Array, std: Array, middle: float) -> float:
    """Spread between arms beyond what their own uncertainty makes of it."""
    total = (CONSISTENT * float(np.median(np.abs(level - middle)))) ** 2
    return float(np.sqrt(max(total - float(np.median(std**2)), 0.0)))
