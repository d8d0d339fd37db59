"""Shafts that do not follow their setpoints: something else drives them."""

from __future__ import annotations

from itertools import product

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.pair import MixUp, Pair, correlation
from trunk_ros.data.noise import alike
from trunk_ros.effects.servo.loop import fresh, servo_loop, unlimited
from trunk_ros.levels import ENOUGH, NOTABLE, OUTLIERS, PART, SOME

GAINS = (0.5, 2.0, 8.0, 32.0, 128.0)  # 1/s
DELAYS = (0.0, 0.1, 0.3, 0.5)  # s
LED = np.sqrt(SOME)  # correlation with what leads to some of a motion


def unled(pair: Pair) -> list[MixUp]:
    """Joints whose shafts go where no loop with a delay leads, whatever its gain and its top speed, nor a
    share of that beside a constant, but for what chance makes: slow, saturated and drooping servos follow,
    too, and those of which a load makes most of the motion.
    """
    if pair.stage != "servo" or len(pair.stamp) < ENOUGH:
        return []
    which = np.array(
        [_is_unled(pair.stamp, *each) for each in zip(pair.source.T, pair.target.T, strict=True)]
    )
    if not which.any():
        return []
    source, target = pair.topics
    said = (
        f"{target} of {', '.join(pair.names(which))} does not follow {source}: no servo with a delay, "
        f"whatever its bandwidth, leads to {100 * SOME:.0f} % of that motion. Something else drives the "
        "motors (a feedforward torque, a hand, a load), or the setpoints are of something else. Nothing "
        "is said of these servos, and the model keeps what it had of them. Record setpoints that the "
        "servos follow, and diagnose again."
    )
    return [pair.found("unled", which, said)]


def _is_unled(stamp: Array, asked: Array, went: Array) -> bool:
    """Of a shaft that ``went`` (n,) rad as it was ``asked`` (n,) or not; of one that stands, or was asked to,
    nothing is told.
    """
    ways = [np.ptp(_inner(one)) for one in (asked, went)]
    if min(ways) <= PART * max(ways) or _told(asked, went) >= LED:
        return False
    told = max(_told(path, went) for path in _paths(stamp, asked, went).T)
    chance = NOTABLE * np.sqrt(alike([went - went.mean()]) / len(went))
    return bool(told < min(LED, chance))


def _inner(values: Array) -> Array:
    """(n,) without how far a few of them go."""
    return np.clip(values, *np.quantile(values, [OUTLIERS, 1.0 - OUTLIERS]))


def _told(path: Array, went: Array) -> float:
    """Correlation of a motion (n,) with a path (n,)."""
    return correlation(_inner(path), _inner(went))


def _paths(stamp: Array, asked: Array, went: Array) -> Array:
    """(n, loops) where loops lead to, fast ones and slow ones, also with the top speed that was seen."""
    steps = np.diff(stamp)
    speeds = np.abs(np.diff(went)[steps > 0.0] / steps[steps > 0.0])
    tops = (np.inf, float(np.quantile(speeds, 1.0 - OUTLIERS)))
    gain, delay, top = map(np.array, zip(*product(GAINS, DELAYS, tops), strict=True))
    many = len(gain)
    none, paths = np.zeros((1, many)), np.empty((len(stamp), many))
    loop = gain[None], 1.0 / (4.0 * gain[None]), top[None], top[None], delay[None]  # critically damped
    teeth = np.zeros((3, 1, many))
    none_of_it = none, none, none, none, none[0], none, teeth, unlimited(many), none, none[:0]
    setpoint, state = np.repeat(asked[:, None], many, axis=1), fresh(np.full(many, went[0]))
    servo_loop(setpoint, stamp, *loop, *none_of_it, 0.0, 0, state, paths)
    return paths
