"""Motions to choose an experiment from: stretches of to and fro, within the limits of the arm."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import product
from math import copysign, inf, sqrt
from typing import Literal

import numpy as np

from trunk_ros.arm.parameters import ANY_ANGLE
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.levels import ENOUGH, HALF, OUTLIERS, SLIGHT, SOME, THREEFOLD
from trunk_ros.motion import LEAD_IN, PEAK, QUICKEST, merge
from trunk_ros.trajectory import Limits, Trajectory

SECONDS = 8.0  # of one stretch
SAMPLES = 2 * ENOUGH  # of one stretch at least: to and fro
MOMENT = 1e-3  # s: too short for a piece of a motion
BEND = round(10.0 / sqrt(3.0), 4)
"""Peak acceleration of a rest-to-rest quintic, times its time squared over its way."""
GENTLE = 20.0  # rad/s^2: arms state no limit of acceleration
BENDS = 8.0 * HALF  # noise over squared sample time: the sagitta between two samples is half the noise
GOLDEN = round((sqrt(5.0) - 1.0) / 2.0, 3)  # the section whose multiples lie apart most evenly
ROOM = 1.0 - SLIGHT  # of a limit

Movers = Literal["own", "others", "all"]


@dataclass(frozen=True)
class Stretch:
    """To and fro about a posture; lengths in parts of the reach, speeds in parts of the top speed, holds in
    s.
    """

    movers: Movers
    """``own``: the joints in question move and the others stand; ``others``: the reverse."""
    centre: float
    size: float
    speed: float
    hold: float = 0.0
    shrink: float = 1.0
    """Each turn over the one before."""


SHAPES = {  # size, speed, hold, shrink: the sections of trunk_ros/motion.py, and what lies between them
    "sweeps": (0.9, 0.4, 0.0, 1.0),
    "fast": (0.55, 0.9, 0.0, 1.0),
    "short": (0.1, 0.9, 0.0, 1.0),
    "reversals": (0.3, 0.25, 0.0, 0.6),
    "holds": (0.75, 0.5, 1.5, 1.0),
    "slow": (0.3, 0.05, 0.0, 1.0),
}
MOVERS: tuple[Movers, ...] = ("own", "others", "all")
CENTRES = (-0.5, 0.5)


def stretches(joints: int, own: Collection[int]) -> list[Stretch]:
    """All stretches about the middle that are worth a look for joints ``own`` of an arm."""
    movers = MOVERS if len(own) < joints else ("all",)
    return [Stretch(who, 0.0, *shape) for who, shape in product(movers, SHAPES.values())]


def elsewhere(part: Stretch) -> list[Stretch]:
    """The same about other postures."""
    return [replace(part, centre=centre) for centre in CENTRES]


def limits_of(context: Context) -> Limits:
    """The arm's own limits; for joints that have none, what they did in the recordings.

    Accelerations stay as they were, or where samples still show what lies between them; setpoints hold
    between theirs.
    """
    arm, views = context.arm, context.views
    seen = np.concatenate([view.span.gearbox * arm.ratio for view in views])
    spans = [(view.span, view.span.recorded) for view in views]
    recorded = [(span.velocity[rows] * arm.ratio, span.grid[rows]) for span, rows in spans]
    speed = np.concatenate([np.abs(velocity) for velocity, _ in recorded])
    bend = np.concatenate([_bend(*each) for each in recorded])
    first, rows = spans[0]
    done, step = np.quantile(bend, 1.0 - OUTLIERS, axis=0), float(np.median(np.diff(first.grid[rows])))
    noise = np.array([each.std for each in context.noise])
    shown = GENTLE * np.ones(len(noise)) if context.stage.name == "servo" else BENDS * noise / step**2
    stated = (arm.lower > -ANY_ANGLE) & (arm.upper < ANY_ANGLE)
    return Limits(
        np.where(stated, arm.lower, seen.min(axis=0)),
        np.where(stated, arm.upper, seen.max(axis=0)),
        np.minimum(arm.v_max * np.abs(arm.ratio), np.where(stated, np.inf, speed.max(axis=0))),
        np.where(stated, np.clip(np.maximum(done, shown), 0.0, GENTLE), done),
    )


def _bend(speed: Array, stamp: Array) -> Array:
    return np.abs(np.gradient(speed, stamp, axis=0)) if len(stamp) > 1 else np.zeros_like(speed)


def motion(context: Context, limits: Limits, parts: list[Stretch], own: Collection[int]) -> Trajectory:
    """The stretches one after the other, from rest at 0 or where the arm may be next to it, as one
    trajectory.
    """
    paths = [_Path(limits, joint, float(top)) for joint, top in enumerate(context.arm.top_speed)]
    begin, seconds = max(path.lead for path in paths), seconds_of(context)
    for joint, path in enumerate(paths):
        path.stay(begin)
        for number, part in enumerate(parts, start=1):
            path.follow(part, joint in own, begin + number * seconds)
    return merge(context.joints, [np.array(path.points) for path in paths])


def seconds_of(context: Context) -> float:
    """How long a stretch takes [s]."""
    return max(SECONDS, min(SAMPLES * context.step, _longest(context)))


def most_of(context: Context, usual: int) -> int:
    """Stretches of a motion at most: as many as ``usual`` where these are short, else a few times as long as
    what was recorded.
    """
    return min(int(max(usual * SECONDS, _longest(context)) / seconds_of(context)), usual)


def _longest(context: Context) -> float:
    return THREEFOLD * sum(float(np.ptp(view.span.stamp)) for view in context.views)


class _Path:
    """Postures at rest (time s, angle rad) of one joint."""

    def __init__(self, limits: Limits, joint: int, fastest: float = inf):
        """``fastest``: top speed with which an arm that stands at 0 comes to where the motion begins."""
        low, high = float(limits.lower[joint]), float(limits.upper[joint])
        self.centre, self.reach = (low + high) / 2, (high - low) / 2 * ROOM
        self.top, self.bend = float(limits.speed[joint]) * ROOM, float(limits.acceleration[joint]) * ROOM
        self.side = 1.0 if joint % 2 else -1.0
        self.pace = 1.0 - SOME * (joint * GOLDEN % 1.0)  # no two joints move alike
        moves = self.top > 0.0 and self.bend > 0.0
        start = min(max(0.0, low), high) if moves else self.centre  # what never moved stays
        self.points = [(0.0, start)]
        self.lead = LEAD_IN
        """Time [s] to come to the start: where that is not 0, from anywhere in the reach."""
        if moves and start:
            self.lead = max(LEAD_IN, self._time(high - low, self.top), PEAK * abs(start) / (ROOM * fastest))

    def _time(self, way: float, speed: float) -> float:
        """s from rest to rest."""
        return max(PEAK * way / speed, sqrt(BEND * way / self.bend), QUICKEST)

    def follow(self, part: Stretch, mine: bool, end: float) -> None:
        """One stretch, until ``end`` s."""
        size, side = part.size, self.side
        if part.movers != "all" and mine != (part.movers == "own"):
            self._go(self.centre + part.centre * self.reach, SOME, end)
            size = 0.0
        going = size > 0.0
        while going:
            target = min(max(part.centre + side * size, -1.0), 1.0)
            going = self._go(self.centre + target * self.reach, part.speed * self.pace, end)
            self.stay(min(self.points[-1][0] + part.hold, end))
            size, side = size * part.shrink, -side
            size = size if size > SLIGHT * part.size else part.size
        self.stay(end)

    def _go(self, angle: float, speed: float, end: float) -> bool:
        """Move to an angle, or as far towards it as there is time for; whether there was any."""
        begin, here = self.points[-1]
        if self.bend <= 0.0:
            return False
        way = min(abs(angle - here), max(end - begin, 0.0) * self.top * speed / PEAK)
        if way <= 0.0:
            return False
        took = self._time(way, self.top * speed)
        in_time = begin + took <= end + MOMENT
        if in_time:
            self.points.append((begin + took, here + copysign(way, angle - here)))
        return in_time

    def stay(self, until: float) -> None:
        """Until a time [s]."""
        if until > self.points[-1][0] + MOMENT:
            self.points.append((until, self.points[-1][1]))
