"""The fleet in numbers: what ``fleet.json`` holds and the page shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.fleet.together.common import Common, Own, common_and_own
from trunk_ros.fleet.together.correction import ALPHA, stands
from trunk_ros.fleet.together.judged import LEAST, Judged, judged, moment, slope
from trunk_ros.fleet.together.series import DAY, Series

SCHEMA = "trunk_ros/fleet/1"
Limits = Mapping[tuple[str, str], float]
"""By effect and parameter, in SI units."""


@dataclass(frozen=True)
class Trend:
    """A value that grows: ``slope`` in ``unit`` per ``per`` with its interval; ``since`` [s since the epoch].

    ``crosses``: when it reaches ``limit`` [s since the epoch], earliest and latest by the interval.
    """

    arm: str
    effect: str
    joint: str
    parameter: str
    slope: float
    interval: tuple[float, float]
    unit: str
    per: str
    since: float
    now: float
    chance: float
    limit: float | None = None
    crosses: tuple[float | None, float | None, float | None] | None = None


@dataclass(frozen=True)
class Change:
    """A value that jumped at ``time`` ± ``std`` [s]."""

    arm: str
    effect: str
    joint: str
    parameter: str
    time: float
    std: float
    step: float
    step_std: float
    unit: str
    chance: float


@dataclass(frozen=True)
class Fleet:
    """All that is said of a fleet. ``arms``: names with the number of recordings that were read."""

    arms: dict[str, int]
    found: list[Judged]
    trends: list[Trend]
    changes: list[Change]
    common: list[Common]
    own: list[Own]
    unread: list[dict[str, str]] = field(default_factory=list)
    looked_at: int = 0
    """Series that were tested."""
    alone: dict[str, list[tuple[str, str, int]]] = field(default_factory=dict)
    """Effect, joint, and how many of the arm's recordings show it by themselves, the most frequent first."""

    @property
    def short(self) -> list[str]:
        """Arms with too few recordings for anything to be said of their life."""
        return [arm for arm, count in self.arms.items() if count < LEAST]

    def to_json(self) -> dict[str, Any]:
        """The dictionary that ``fleet.json`` holds."""
        arms = {
            arm: {
                "recordings": count,
                "judged": arm not in self.short,
                "trends": [_trend(each) for each in self.trends if each.arm == arm],
                "changes": [_change(each) for each in self.changes if each.arm == arm],
                "own": [_less(asdict(each), "arm") for each in self.own if each.arm == arm],
            }
            for arm, count in self.arms.items()
        }
        return {
            "schema": SCHEMA,
            "arms": arms,
            "common": [asdict(each) for each in self.common],
            "unread": self.unread,
            "looked_at": self.looked_at,
            "alpha": ALPHA,
        }


def summarised(
    all_series: list[Series],
    arms: dict[str, int],
    unread: list[dict[str, str]],
    limits: Limits | None = None,
) -> Fleet:
    """Judge all series; only what stands after correction for their number is a trend or a change."""
    found = judged(all_series)
    kept = stands([one.chance for one in found])
    least = max((one.chance for one, keep in zip(found, kept, strict=True) if keep), default=0.0)
    found = [one if keep else one.constant for one, keep in zip(found, kept, strict=True)]
    trends = [t for one in found if one.shape.kind in ("line", "bend") for t in _trends(one, limits or {})]
    changes = [c for one in found for c in _changes(one, least)]
    shared, own = common_and_own(found, list(arms))
    return Fleet(arms, found, trends, changes, shared, own, unread, len(found))


def _trends(one: Judged, limits: Limits) -> list[Trend]:
    """Over days, and over metres where they are known."""
    series, key = one.series, one.series.key
    start = series.time[one.shape.places[0] - 1] if one.shape.kind == "bend" else series.time[0]
    axes: dict[str, Array] = {"day": series.days}
    if np.isfinite(series.travel).all() and np.ptp(series.travel) > 0.0:
        axes["m"] = series.travel
    limit = limits.get((key.effect, key.parameter))
    out = []
    for per, x in axes.items():
        middle, low, high = slope(one, x)
        crosses = None if limit is None or per != "day" else _crossing(one, limit, (middle, low, high))
        out.append(
            Trend(
                *key, middle, (low, high), series.unit, per, float(start), one.level[0], one.chance,
                limit if per == "day" else None, crosses,
            )
        )  # fmt: skip
    return out


def _crossing(
    one: Judged, limit: float, slopes: tuple[float, float, float]
) -> tuple[float | None, float | None, float | None]:
    """When the value reaches a limit: likeliest, earliest, latest [s since the epoch]; None where never."""
    now, last = one.level[0], float(one.series.time[-1])
    middle, low, high = slopes
    if abs(now) >= abs(limit):
        return last, last, last
    towards = math.copysign(limit, now if now else middle)

    def at(rate: float) -> float | None:
        ahead = (towards - now) / rate if rate else -1.0
        return last + ahead * DAY if ahead > 0.0 else None

    ends = (low, high) if towards < 0.0 else (high, low)
    return at(middle), at(ends[0]), at(ends[1])


def _changes(one: Judged, least: float) -> list[Change]:
    """The jumps of a series, each as sure by itself as the least sure of all that stands."""
    out = []
    for jump in one.jumps if one.shape.kind == "jumps" else ():
        if jump.chance <= least:
            when, std = moment(one, jump)
            out.append(Change(*one.series.key, when, std, jump.step, jump.std, one.series.unit, jump.chance))
    return out


def date(seconds: float | None) -> str | None:
    """A time in ISO 8601, None where it is none that a calendar has."""
    try:
        return None if seconds is None else datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")
    except (OverflowError, ValueError, OSError):
        return None


def _trend(each: Trend) -> dict[str, Any]:
    out = _less(asdict(each), "arm") | {"interval": list(each.interval)}
    if each.crosses is not None:
        when = dict(zip(("time", "earliest", "latest"), each.crosses, strict=True))
        out["crosses"] = when | {"date": date(each.crosses[0])}
    return {key: value for key, value in out.items() if value is not None}


def _change(each: Change) -> dict[str, Any]:
    return _less(asdict(each), "arm") | {"date": date(each.time)}


def _less(fields: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in fields.items() if key != name}
