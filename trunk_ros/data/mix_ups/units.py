"""Degrees for radians, counts of an encoder for either, and motors for joints: what the sizes tell."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.pair import FOLLOWS, MixUp, Pair, own_correlation
from trunk_ros.data.sensing.wraps import TURN
from trunk_ros.levels import CLEARLY, HALF, SEVERAL, TENFOLD
from trunk_ros.recording.signal.encoder import count

CLOSE, CLOSER = np.log(1.15), np.log(1.03)  # to that factor: where the ratio is known, and where it is not
WHOLE = 100.0  # rad: a joint that goes so far does not read whole radians only
TO_DO = "Convert it to rad (unit: deg in a mapping) and diagnose again."


def counts(pair: Pair) -> list[MixUp]:
    """Joints whose readings are whole numbers that go far: counts of an encoder."""
    out = []
    for values, topic in zip((pair.source, pair.target), pair.topics, strict=True):
        whole = np.array([_is_whole(column) for column in values.T]) & pair.angles
        if whole.any():
            low, high = values[:, whole].min(), values[:, whole].max()
            said = (
                f"{topic} of {', '.join(pair.names(whole))} looks like encoder counts: whole numbers from "
                f"{low:.0f} to {high:.0f}. Convert them to rad by a mapping, "
                '{expr: "counts * 2 * pi / COUNTS_PER_TURN"}, and diagnose again.'
            )
            out.append(pair.found("counts", whole, said))
    return out


def _is_whole(readings: Array) -> bool:
    """Whether readings (n,) go far in whole numbers; between two of them, interpolated, some are not."""
    step = count(readings[readings == np.rint(readings)]) if np.ptp(readings) > WHOLE else 0.0
    return step >= 1.0 and float(np.mean(readings == np.rint(readings))) > HALF


def degrees(pair: Pair) -> list[MixUp]:
    """Joints of which one topic is in degrees, or both are."""
    moves = (np.abs(own_correlation(pair)) > FOLLOWS) & pair.angles
    if not moves.any():
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.log(_spread(pair.target) / _spread(pair.driven))
    degree = np.log(np.degrees(1.0))
    near = CLOSE if pair.ratio_known else CLOSER
    large_target = moves & (np.abs(times - degree) < near)
    large_source = moves & (np.abs(times + degree) < near)
    if not pair.ratio_known:  # one joint with a gear of 57 to 1 is one with a gear
        large_target, large_source = (w & bool((w == moves).all()) for w in (large_target, large_source))
    both = moves & (np.abs(times) < CLOSE) & (np.abs(pair.target).max(axis=0) > TENFOLD * pair.limit)
    return [
        *([_one(pair, large_target, pair.target, *pair.topics[::-1])] if large_target.any() else []),
        *([_one(pair, large_source, pair.driven, *pair.topics)] if large_source.any() else []),
        *([_both(pair, both)] if both.any() else []),
    ]


def _one(pair: Pair, which: np.ndarray, values: Array, large: str, small: str) -> MixUp:
    """``values`` (n, joints): of the topic with the larger numbers, on the target's side."""
    bound = np.where(np.isfinite(pair.limit), 2.0 * pair.limit, TURN)  # joints without limits: about a turn
    beyond = (np.abs(values).max(axis=0) > bound)[which].any()
    other = "" if beyond else f", or {small} like radians that were taken for degrees"
    said = (
        f"{large} looks like degrees{other}: on {', '.join(pair.names(which))} it is 57.3 (180/π) times what "
        f"{small} leads to expect. {TO_DO}"
    )
    return pair.found("unit", which, said)


def _both(pair: Pair, which: np.ndarray) -> MixUp:
    most, limit = np.abs(pair.target[:, which]).max(), pair.limit[which].max()
    if most > TENFOLD * np.degrees(limit):
        said = (
            f"{' and '.join(pair.topics)} of {', '.join(pair.names(which))} are neither rad nor degrees: up "
            f"to {most:.3g}, where the model's limits are {limit:.3g} rad. Convert them from what they are "
            "(thousandths of a degree? counts?) by an expr in a mapping, and diagnose again."
        )
        return pair.found("unit", which, said)
    said = (
        f"{' and '.join(pair.topics)} of {', '.join(pair.names(which))} look like degrees: up to {most:.3g}, "
        f"where the model's limits are {limit:.3g} rad. {TO_DO}"
    )
    return pair.found("unit", which, said)


def exchanged(pair: Pair) -> list[MixUp]:
    """Joints that go as far as motors would beside them, all of them that the model has turn otherwise than
    their motors: each of the two is the other one, or the model has its ratios the wrong way round. A single
    one may have another ratio.
    """
    geared = np.abs(np.log(np.abs(pair.factor))) > np.log(CLEARLY)
    moves = (np.abs(own_correlation(pair)) > FOLLOWS) & pair.angles & geared
    if pair.stage != "wire" or not pair.ratio_known or not moves.any():
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.log(_spread(pair.target[:, moves]) / _spread(pair.driven[:, moves]))
        back = -2.0 * np.log(np.abs(pair.factor[moves]))
        near = np.abs(times - back) < CLOSE
    if not near.all():
        return []
    source, target = pair.topics
    said = (
        f"motor and joint side exchanged? {target} of {', '.join(pair.names(moves))} goes as far beside "
        f"{source} as the model has it the other way round. Exchange the two in the driver or the mapping, "
        "or write wire.ratio as joint angle per motor angle, and diagnose again."
    )
    return [pair.found("order", moves, said, certain=bool(moves.sum() >= SEVERAL))]


def joint_sided(pair: Pair) -> list[MixUp]:
    """Setpoints that go as far as joints would whose motors go as these do, on all joints that the model has
    turn otherwise than their motors: they were noted at the joint. A single one may not get there.
    """
    geared = np.abs(np.log(np.abs(pair.ratio))) > np.log(CLEARLY)
    moves = (np.abs(own_correlation(pair)) > FOLLOWS) & pair.angles & geared
    if pair.stage != "servo" or moves.sum() < SEVERAL:
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.log(_spread(pair.source[:, moves]) / _spread(pair.target[:, moves]))
    if not np.all(np.abs(times - np.log(np.abs(pair.ratio[moves]))) < CLOSE):
        return []
    source, target = pair.topics
    said = (
        f"setpoints at the joint side? {source} of {', '.join(pair.names(moves))} goes as far beside "
        f"{target} as the model has the joint go beside its motor. Divide it by wire.ratio (expr in a "
        "mapping) and diagnose again."
    )
    return [pair.found("unit", moves, said)]


def _spread(values: Array) -> Array:
    low, high = np.quantile(values, [0.02, 0.98], axis=0)
    return np.asarray(high - low)
