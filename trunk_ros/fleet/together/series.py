"""One number of one arm over its life: the size of an effect on a joint, recording by recording."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects import effect, registry
from trunk_ros.fleet.run.outcome import Row

DAY = 86_400.0  # s
FAR = 6.0  # deviations from both neighbourhoods: a recording that stands apart
BESIDE = 3  # recordings on each side that it is compared with
SIZES = ("payload",)  # parameters that are sizes besides an effect's first


class Key(NamedTuple):
    """Of which arm, effect, joint (``arm`` where shared) and parameter."""

    arm: str
    effect: str
    joint: str
    parameter: str


@dataclass(frozen=True)
class Series:
    """``time`` [s since the epoch] rising, ``travel`` [m] of wire run before each recording (NaN where not
    known), ``value`` and ``std`` in ``unit``; all (n,). ``apart``: recordings that fit neither side's.
    """

    key: Key
    unit: str
    time: Array
    travel: Array
    value: Array
    std: Array
    recording: tuple[str, ...] = ()

    @property
    def days(self) -> Array:
        """(n,) days since the first recording."""
        return np.asarray((self.time - self.time[0]) / DAY)

    @property
    def sigma(self) -> Array:
        """(n,) stated spreads for weighing; no recording counts for more than four usual ones."""
        usual = float(np.median(self.std)) or 1.0
        return np.asarray(np.hypot(self.std, 0.5 * usual))

    def apart(self) -> np.ndarray:
        """(n,) whether a recording is far from those before and from those after it alike.

        The first and the last have one side only: they are apart where no other step is nearly as large. What
        one recording alone says is no change yet.
        """
        z = self.value / float(np.median(self.sigma))
        out, far = np.zeros(len(z), dtype=bool), FAR * spread_of_steps(z)
        for k in range(len(z) if len(z) > BESIDE else 0):
            sides = [side for side in (z[max(k - BESIDE, 0) : k], z[k + 1 : k + 1 + BESIDE]) if len(side)]
            away = [z[k] - float(np.median(side)) for side in sides]
            usual = far if len(sides) == 2 else max(far, 2.0 * _largest_step(np.delete(z, k)))
            out[k] = min(away) > usual or max(away) < -usual
        return out

    def kept(self) -> Series:
        """The series without recordings that stand apart."""
        keep = ~self.apart()
        names = tuple(name for name, k in zip(self.recording, keep, strict=False) if k)
        return Series(
            self.key, self.unit, self.time[keep], self.travel[keep], self.value[keep], self.std[keep], names
        )


def spread_of_steps(z: Array) -> float:
    """Standard deviation of a series (n,) from the middle of the steps between its neighbours."""
    if len(z) < 3:
        return 1.0
    return max(float(np.median(np.abs(np.diff(z)))) / 0.9539, 1e-12)  # 0.6745 √2


def _largest_step(z: Array) -> float:
    return float(np.max(np.abs(np.diff(z)), initial=0.0))


def is_size(name: str, parameter: str, form: str) -> bool:
    """Whether a parameter says how large an effect is, not where or when it acts."""
    if name not in registry():
        return False
    return parameter in (effect(name).own_parameters(form)[0].name, *SIZES)


def collected(rows: Iterable[Row], travels: dict[tuple[str, str], float]) -> list[Series]:
    """The series that flat rows hold: with ``arm, time, recording, path`` and a value each.

    ``travels``: metres before a recording, by path and joint.
    """
    points: dict[Key, list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        known = row["value"] is not None and row["std"] is not None and row["std"] > 0.0
        if known and is_size(row["effect"], row["parameter"], row["form"] or ""):
            points[Key(row["arm"], row["effect"], row["joint"], row["parameter"])].append(row)
    return [_series(key, points[key], travels) for key in sorted(points)]


def _series(key: Key, rows: list[dict[str, Any]], travels: dict[tuple[str, str], float]) -> Series:
    rows = sorted(rows, key=lambda row: (row["time"], row["path"]))

    def column(name: str) -> Array:
        return np.array([row[name] for row in rows], dtype=float)

    travel = np.array([travels.get((row["path"], key.joint), np.nan) for row in rows])
    names = tuple(str(row["recording"]) for row in rows)
    return Series(key, rows[0]["unit"], column("time"), travel, column("value"), column("std"), names)


def travels_of(outcomes: Iterable[Row]) -> dict[tuple[str, str], float]:
    """Metres of wire that ran before each recording, by path and joint; ``arm``: the mean of all joints.

    Only what was recorded counts.
    """
    run: dict[tuple[str, str], float] = defaultdict(float)
    out: dict[tuple[str, str], float] = {}
    for row in sorted(outcomes, key=lambda row: (row["arm"], row["time"], row["path"])):
        own = {entry["joint"]: entry["metres"] for entry in row["travel"] or ()}
        if own:
            own["arm"] = float(np.mean(list(own.values())))
        for joint, metres in own.items():
            out[row["path"], joint] = run[row["arm"], joint]
            run[row["arm"], joint] += metres
    return out
