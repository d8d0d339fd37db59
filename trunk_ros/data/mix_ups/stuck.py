"""Readings that stand for the whole recording while the other side of the joint goes far."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.pair import FOLLOWS, MixUp, Pair, correlation, own_correlation
from trunk_ros.data.motion_content import STANDS, STILL, comes_back, in_its_play
from trunk_ros.levels import CLEARLY, ENOUGH, OUTLIERS, PART, SOME

GOES_FAR = 0.1  # rad or m: further than a load, time or others move a joint whose motor stands


def stuck(pair: Pair, pushed: np.ndarray) -> list[MixUp]:
    """Joints that never move while their motors do, and motors that never move while their joints do; of
    servos the first alone. ``pushed`` (joints,): on which a sensor measures a load, that may move them.
    """
    if len(pair.stamp) < ENOUGH:
        return []
    unlike = np.abs(own_correlation(pair)) < SOME
    rests = unlike & _stand(pair.driven, pair.target) & (pair.stage == "wire")
    dead = unlike & _stand(pair.target, pair.driven) & (_spread(pair.driven) > GOES_FAR)
    dead &= ~_followed(pair, by=rests)
    unmoved = rests & ~pushed
    unmoved &= np.array([still and _goes_by_itself(pair, joint) for joint, still in enumerate(unmoved)])
    source, target = pair.topics
    return [
        *(
            [_said(pair, dead, target, source, pair.source, "nothing hands the motion on")]
            if dead.any()
            else []
        ),
        *([_said(pair, unmoved, source, target, pair.target, "a hand moves it")] if unmoved.any() else []),
    ]


def _followed(pair: Pair, by: np.ndarray) -> np.ndarray:
    """(joints,): whose motor is followed by another joint, of those chosen ``by`` (joints,): swapped ones."""
    shown = pair.target[:, by].T
    return np.array([any(abs(correlation(path, each)) > FOLLOWS for each in shown) for path in pair.driven.T])


def _said(pair: Pair, which: np.ndarray, still: str, moved: str, path: Array, why: str) -> MixUp:
    """That one topic stands where the other one moves along a ``path`` (n, joints)."""
    unit = "rad" if pair.angles[which].all() else "m" if not pair.angles[which].any() else "rad or m"
    said = (
        f"{still} of {', '.join(pair.names(which))} never moves, while {moved} goes up to "
        f"{_spread(path)[which].max():.2g} {unit} from end to end: the sensor is dead, the column is the "
        f"wrong one, or {why}. Correct it, and diagnose again."
    )
    return pair.found("stuck", which, said)


def _stand(readings: Array, other: Array) -> np.ndarray:
    """(joints,): whose readings (n, joints) stand, beside those of the other side."""
    small = np.std(readings, axis=0) < STILL * np.std(other, axis=0)
    return np.asarray(small & [_stands(column) for column in readings.T])


def _stands(readings: Array) -> bool:
    """Whether readings (n,) are one, but for white noise."""
    inner = np.clip(readings, *_ends(readings))
    noise = float(np.std(np.diff(inner))) / np.sqrt(2.0)
    return bool(np.ptp(inner) < STANDS or np.std(inner) < CLEARLY * noise)


def _goes_by_itself(pair: Pair, joint: int) -> bool:
    """Whether a joint goes far and comes back, and neither time nor the motors of others tell why."""
    shown = pair.target[:, joint]
    if _spread(shown[:, None])[0] < GOES_FAR or not comes_back(shown):
        return False
    late = pair.stamp - pair.stamp.mean()
    told = [np.ones_like(late), late, late**2]
    for path in np.delete(pair.driven, joint, axis=1).T:
        if not _stands(path):
            speed = np.gradient(path)
            told += [np.sin(path), np.cos(path), speed, np.abs(speed), in_its_play(path, PART * np.ptp(path))]
    beside = np.column_stack(told)
    left = shown - beside @ np.linalg.lstsq(beside, shown, rcond=None)[0]
    return bool(np.var(left) > (1.0 - SOME) * np.var(shown))


def _spread(values: Array) -> Array:
    """(joints,) from end to end of most of (n, joints)."""
    return np.asarray(np.subtract(*_ends(values)[::-1]))


def _ends(values: Array) -> Array:
    return np.asarray(np.quantile(values, [OUTLIERS, 1.0 - OUTLIERS], axis=0))
