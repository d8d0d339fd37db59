"""Two topics of which one drives the other, at common times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from trunk_ros.arm.parameters import ANY_ANGLE
from trunk_ros.arm_model import ArmModel
from trunk_ros.compiled import Array
from trunk_ros.levels import FEWEST, ROWS, SLIGHT, TENFOLD
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.topics import COMPARED, TOPICS

FOLLOWS = 1.0 - SLIGHT  # correlation of a joint with what turns it, wide loops and long lags included

Kind = Literal["unit", "counts", "sign", "order", "clock", "guided", "unled", "stuck", "copy", "magnitude"]


@dataclass(frozen=True)
class MixUp:
    """What is mixed up between the topics of a stage, on which joints, and what to do about it."""

    kind: Kind
    stage: str
    joints: tuple[str, ...]
    statement: str
    certain: bool = True
    """Nothing else can look like this; else it is a remark."""


@dataclass(frozen=True)
class Pair:
    """What turns each joint and what the joint reads at those times, both (n, joints) as recorded."""

    stage: str
    joints: tuple[str, ...]
    stamp: Array
    """(n,) s."""
    angles: np.ndarray
    """(joints,) whether the joint turns: others are in m."""
    source: Array
    target: Array
    factor: Array
    """(joints,) target over source, as the model has it."""
    limit: Array
    """(joints,) largest angle of the target within the model's limits; inf where it states none."""
    ratio: Array
    """(joints,) joint angle per motor-side angle, as the model has it."""
    ratio_known: bool

    @property
    def topics(self) -> tuple[str, str]:
        """Names of the two topics."""
        source, target = COMPARED[self.stage]
        return TOPICS[source], TOPICS[target]

    @property
    def driven(self) -> Array:
        """(n, joints) what the model expects the target to read, roughly."""
        return self.source * self.factor

    def names(self, which: np.ndarray) -> tuple[str, ...]:
        """The joints chosen by ``which`` (joints,)."""
        return tuple(joint for joint, one in zip(self.joints, which, strict=True) if one)

    def found(self, kind: Kind, which: np.ndarray, statement: str, certain: bool = True) -> MixUp:
        """A mix-up on the joints chosen by ``which`` (joints,)."""
        return MixUp(kind, self.stage, self.names(which), statement, certain)


def pair_of(
    recording: Recording,
    model: ArmModel,
    stage: str,
    source: JointSeries,
    target: JointSeries,
    in_a_row: bool = False,
) -> Pair | None:
    """The two topics, which have the same joints, where both were recorded; None for too few samples. Of many
    samples some, or as many as begin it ``in_a_row``.
    """
    arm = model.for_joints(source.joints).arm.only(source.joints)
    rows = slice(int(TENFOLD) * ROWS) if in_a_row else slice(None, None, max(len(target.stamp) // ROWS, 1))
    stamp, shown = target.stamp[rows], target.position[rows]
    driving = np.column_stack([_at(stamp, source.stamp, column) for column in source.position.T])
    kept = np.isfinite(driving).all(axis=1) & np.isfinite(shown).all(axis=1)
    kept &= (stamp >= source.stamp[0]) & (stamp <= source.stamp[-1])
    if kept.sum() < FEWEST:
        return None
    limit = np.maximum(np.abs(arm.lower), np.abs(arm.upper))
    limit = np.where(limit < ANY_ANGLE, limit, np.inf)
    wire = stage == "wire"
    factor = arm.ratio if wire else np.ones(len(source.joints))
    angles = np.array([recording.unit(joint) == "rad" for joint in source.joints])
    limit = limit if wire else limit / np.abs(arm.ratio)
    known = not (wire and model.any_joints)
    both = driving[kept], shown[kept]
    return Pair(stage, source.joints, stamp[kept], angles, *both, factor, limit, arm.ratio, known)


def _at(stamp: Array, source: Array, column: Array) -> Array:
    known = np.isfinite(column)
    return np.interp(stamp, source[known], column[known]) if known.any() else np.full(len(stamp), np.nan)


def correlation(a: Array, b: Array) -> float:
    """Of two signals (n,); 0 where one stands."""
    a, b = a - a.mean(), b - b.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0.0 else 0.0


def own_correlation(pair: Pair) -> Array:
    """(joints,) correlation of each joint with what turns it."""
    return np.array([correlation(a, b) for a, b in zip(pair.driven.T, pair.target.T, strict=True)])
