"""Joints that lead their motors: an arm that a hand guides turns its motors through the play of its wires."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.mix_ups.pair import MixUp, Pair
from trunk_ros.data.motion_content import APART, in_its_play
from trunk_ros.guards import SAME, TINY
from trunk_ros.levels import (
    CERTAIN,
    CLEARLY,
    ENOUGH,
    HALF,
    NEARLY,
    NOTABLE,
    OUTLIERS,
    PART,
    SURE,
    TENFOLD,
    THREEFOLD,
)


@dataclass(frozen=True)
class Lead:
    """By how much a joint is ahead of its motor on the way up, and behind on the way down."""

    times: float
    """How far, in standard deviations."""
    better: float
    """In standard deviations, how much more of its angle a play that the motor follows it through explains
    than one through which it follows the motor, or none."""
    half_width: float
    """Of the play, where the motor follows the joint."""
    left: float
    """Standard deviation of what the play leaves."""

    @property
    def is_certain(self) -> bool:
        """Whether nothing else can look like it."""
        return self.times > CERTAIN and self.better > SURE and self.half_width > THREEFOLD * self.left


def guided(pair: Pair) -> list[MixUp]:
    """Joints whose motors follow them through a play. Friction makes a joint that its motor turns late by a
    loop, whatever friction it is: a loop of the other sign takes its energy from the joint's side.
    """
    if pair.stage != "wire" or len(pair.stamp) < ENOUGH:
        return []
    led = [lead(pair, joint) for joint in range(len(pair.joints))]
    if not any(one.is_certain for one in led):
        return []
    which = np.array([one.times > CERTAIN and one.better > 0.0 for one in led])  # as one is for certain
    least, most = (1e3 * end(one.half_width for one, of in zip(led, which, strict=True) if of)
                   for end in (min, max))  # fmt: skip
    source, target = pair.topics
    wide = f"{least:.2g}" if most < CLEARLY * least else f"{least:.2g} to {most:.2g}"
    unit = "mrad" if pair.angles[which].all() else "mm" if not pair.angles[which].any() else "mrad or mm"
    said = (
        f"guided by hand? {target} of {', '.join(pair.names(which))} leads {source}, which follows through "
        f"a play of ± {wide} {unit}: the joints turned their motors, and wires do not do then what "
        "they do when motors pull (or the columns of the two sides are exchanged, or the encoder of the "
        "motor side sits loose on its shaft). Record a motion that the motors make, and diagnose again."
    )
    return [pair.found("guided", which, said)]


def lead(pair: Pair, joint: int) -> Lead:
    """What a joint shows of that."""
    none = Lead(0.0, 0.0, 0.0, np.inf)
    ahead, ratio = _ahead(pair.driven[:, joint], pair.target[:, joint])
    if ratio == 0.0:
        return none
    drive = ratio * pair.driven[:, joint]
    low, high = np.quantile(ahead, [OUTLIERS, 1.0 - OUTLIERS])
    far = CLEARLY * (high - low) / 2.0
    if not SAME * np.ptp(drive) < far < HALF * np.ptp(drive):
        return none
    side = in_its_play(drive, far)
    stroke = np.cumsum(np.diff(np.sign(side), prepend=np.sign(side[0])) != 0.0)
    engaged = np.abs(side) > NEARLY
    if engaged.sum() < ENOUGH or len(np.unique(stroke[engaged])) < TENFOLD:
        return none
    beside = _beside(pair, joint, drive, far)
    by, times = _by(np.sign(side[engaged]), beside[engaged], ahead[engaged], stroke[engaged])
    if times < SURE:
        return none
    smooth = np.convolve(
        np.pad(pair.target[:, joint], APART // 2, "edge"), np.full(APART, 1.0 / APART), "valid"
    )
    return _by_a_play(drive, smooth, by, times, beside, ahead, stroke)


def _ahead(drive: Array, shown: Array) -> tuple[Array, float]:
    """How far a joint (n,) is beyond what its motor leads to expect, and its ratio; 0 where one stands."""
    moved = drive - drive.mean()
    power = float(moved @ moved)
    ratio = float(moved @ shown) / power if power > 0.0 else 0.0
    off = shown - ratio * drive
    return off - off.mean(), ratio


def _beside(pair: Pair, joint: int, drive: Array, far: float) -> Array:
    """(n, k) what else a joint's angle may go by: its place, its speed and how that grows with time, its
    acceleration, time, and the place, speed and friction of the others.
    """
    stamp = _unit(pair.stamp)
    place, speed = _unit(drive), _unit(_speed(pair.stamp, drive))
    rush = _unit(_speed(pair.stamp, speed))
    out = [np.ones_like(drive), place, place**2, place**3, speed, speed * np.abs(speed), speed * stamp]
    out += [rush, stamp, stamp**2]
    for other, path in enumerate(pair.driven.T):
        if other != joint and np.ptp(path) > 0.0:
            out += [_unit(path), _unit(_speed(pair.stamp, path)), in_its_play(path, far)]
    return np.column_stack(out)


def _speed(stamp: Array, path: Array) -> Array:
    """(n,) per s, over some samples."""
    once = np.flatnonzero(np.diff(stamp, prepend=-np.inf) > 0.0)
    speed = np.interp(stamp, stamp[once], np.gradient(path[once], stamp[once]))
    return np.convolve(speed, np.full(APART, 1.0 / APART), "same")


def _unit(values: Array) -> Array:
    size = float(np.std(values))
    return np.asarray((values - values.mean()) / (size if size > 0.0 else np.inf))


def _by(side: Array, beside: Array, ahead: Array, stroke: np.ndarray) -> tuple[float, float]:
    """How far a joint is ahead on either way beside all else, and in how many standard deviations, over
    strokes. Nothing where its speed says as well which way it goes: a lead by time would do the same.
    """
    own = side - beside @ np.linalg.lstsq(beside, side, rcond=None)[0]
    power = float(own @ own)
    if power < PART * len(side):
        return 0.0, 0.0
    by = float(own @ ahead) / power
    left = ahead - beside @ np.linalg.lstsq(beside, ahead, rcond=None)[0] - by * own
    score = np.bincount(stroke, own * left)
    std = float(np.sqrt(score @ score)) / power
    return by, by / max(std, TINY)


def _by_a_play(
    drive: Array, shown: Array, by: float, times: float, beside: Array, ahead: Array, stroke: np.ndarray
) -> Lead:
    """Whether the joint's play leaves less of its angle than its motor's does, and less than no play."""
    widths = by * np.geomspace(HALF, NOTABLE, APART)
    (off, half_width), (rival, _) = (
        min(
            (_left(in_its_play(path, w), beside, ahead) for w in widths),
            key=lambda one: float(one[0] @ one[0]),
        )
        for path in (shown, drive)
    )
    nothing = ahead - beside @ np.linalg.lstsq(beside, ahead, rcond=None)[0]
    gains = np.array([np.bincount(stroke, other**2 - off**2) for other in (rival, nothing)])
    better = gains.sum(axis=1) / np.maximum(np.std(gains, axis=1) * np.sqrt(gains.shape[1]), TINY)
    return Lead(times, float(better.min()) if half_width > 0.0 else 0.0, half_width, float(np.std(off)))


def _left(side: Array, beside: Array, ahead: Array) -> tuple[Array, float]:
    """What a play and all else leave (n,), and how far the play goes."""
    all_of_it = np.column_stack([side, beside])
    found = np.linalg.lstsq(all_of_it, ahead, rcond=None)[0]
    return ahead - all_of_it @ found, float(found[0])
