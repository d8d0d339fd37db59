"""Tables of a fleet as if all its recordings had been diagnosed: the together-analysis alone, at full size.

Stated deviations are off by a factor, some recordings stand apart, some are missing: as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from test.concealed.nominal import JOINTS, Array

DAY = 86_400.0
BEGIN = 1_750_000_000.0
WEAR, SLIP, PULLEY, PAYLOAD = "backlash", "zero_offset", "ratio_error", "load_elasticity"
PARAMETER = {WEAR: "half_width", SLIP: "offset", PULLEY: "relative", PAYLOAD: "payload"}
UNIT = {WEAR: "rad", SLIP: "rad", PULLEY: "1", PAYLOAD: "kg"}
SIZE = {WEAR: 3e-5, SLIP: 4e-5, PULLEY: 3e-4, PAYLOAD: 2e-3}
"""Usual scatter from recording to recording."""


@dataclass
class Table:
    """Rows of values as the second task gives them, and what is hidden in them."""

    rows: list[dict[str, Any]] = field(default_factory=list)
    trends: dict[tuple[str, str, str], float] = field(default_factory=dict)
    """By arm, effect and joint: slope per day."""
    changes: dict[tuple[str, str, str], tuple[float, float]] = field(default_factory=dict)
    """By arm, effect and joint: between which two recordings [s since the epoch]."""
    batch: list[str] = field(default_factory=list)
    """Arms with another pulley."""


def made(seed: int, arms: int = 30, recordings: int = 30, still: bool = False) -> Table:
    """A fleet. ``still``: nothing changes on any arm."""
    rng = np.random.default_rng(seed)
    out = Table()
    kinds = ["none"] * arms if still else kinds_of(arms)
    for number, kind in zip(rng.permutation(arms), kinds, strict=True):
        arm = f"arm_{number:02d}"
        time = BEGIN + np.cumsum(rng.uniform(0.2, 5.0, recordings)) * DAY
        places = [(WEAR, j) for j in JOINTS] + [(SLIP, j) for j in JOINTS]
        for effect, joint in [*places, (PULLEY, "joint_4"), (PAYLOAD, "arm")]:
            course = np.full(recordings, SIZE[effect] * rng.uniform(0.0, 10.0))
            out.rows += _rows(rng, arm, effect, joint, time, course)
        _hide(rng, out, arm, kind, time)
    return out


def kinds_of(arms: int) -> list[str]:
    """A third wears, a fifth slipped, a sixth has another pulley, a tenth another payload from a day on."""
    counts = {"wear": arms // 3, "slip": arms // 5, "pulley": arms // 6, "payload": max(arms // 10, 1)}
    kinds = [kind for kind, count in counts.items() for _ in range(count)]
    return kinds + ["none"] * (arms - len(kinds))


def _hide(rng: np.random.Generator, out: Table, arm: str, kind: str, time: Array) -> None:
    joint = str(rng.choice(JOINTS))
    size = float(np.exp(rng.uniform(np.log(5.0), np.log(50.0))))
    if kind == "wear":
        since = time[int(rng.integers(0, len(time) // 2))] if rng.uniform() < 0.4 else time[0]
        slope = size * SIZE[WEAR] / (time[-1] - since)
        _add(out, arm, WEAR, joint, np.maximum(time - since, 0.0) * slope)
        out.trends[arm, WEAR, joint] = slope * DAY
    elif kind in ("slip", "payload"):
        effect, joint = (SLIP, joint) if kind == "slip" else (PAYLOAD, "arm")
        place = int(rng.integers(3, len(time) - 3))
        _add(out, arm, effect, joint, (np.arange(len(time)) >= place) * size * SIZE[effect])
        out.changes[arm, effect, joint] = float(time[place - 1]), float(time[place])
    elif kind == "pulley":
        _add(out, arm, PULLEY, "joint_4", np.full(len(time), 20.0 * 10.0 * SIZE[PULLEY]))
        out.batch.append(arm)


def _add(out: Table, arm: str, effect: str, joint: str, more: Array) -> None:
    mine = [row for row in out.rows if (row["arm"], row["effect"], row["joint"]) == (arm, effect, joint)]
    for row in mine:
        row["value"] += float(more[row["number"]])


def _rows(
    rng: np.random.Generator, arm: str, effect: str, joint: str, time: Array, course: Array
) -> list[dict[str, Any]]:
    scatter = SIZE[effect] * np.exp(rng.normal(0.0, 0.4, len(time)))  # some motions tell more than others
    truth = rng.uniform(0.7, 2.0)  # stated deviations are too small, or too large
    value = course + rng.normal(size=len(time)) * scatter * truth
    odd = rng.uniform(size=len(time)) < 0.02
    value[odd] += rng.normal(size=int(odd.sum())) * 20.0 * SIZE[effect]
    there = rng.uniform(size=len(time)) > 0.03
    return [
        {
            "arm": arm, "time": float(time[k]), "recording": f"run_{k:02d}", "path": f"{arm}/run_{k:02d}",
            "number": k, "stage": "wire", "joint": joint, "effect": effect, "parameter": PARAMETER[effect],
            "value": float(value[k]), "std": float(scatter[k]), "unit": UNIT[effect], "form": "",
        }
        for k in np.flatnonzero(there)
    ]  # fmt: skip


@dataclass(frozen=True)
class Score:
    """What was found of what was hidden: right, missed, and false ones."""

    right: int
    missed: int
    false: int
    near: int = 0
    """Changes on the right day, within one recording."""

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall; 1 where there was nothing to find and nothing was found."""
        all_ = 2 * self.right + self.missed + self.false
        return 1.0 if all_ == 0 else 2 * self.right / all_

    def __add__(self, other: Score) -> Score:
        return Score(
            self.right + other.right, self.missed + other.missed, self.false + other.false,
            self.near + other.near,
        )  # fmt: skip


def trends_scored(table: Table, found: list[Any]) -> Score:
    """Trends by arm, effect and joint."""
    said = {(t.arm, t.effect, t.joint) for t in found}
    right = len(said & table.trends.keys())
    return Score(right, len(table.trends) - right, len(said) - right)


def changes_scored(table: Table, found: list[Any]) -> Score:
    """Changes by arm, effect and joint, and how many are dated between the right two recordings or next to
    them.
    """
    said = {(c.arm, c.effect, c.joint): c for c in found}
    right = said.keys() & table.changes.keys()
    near = sum(_near(table, key, said[key].time) for key in right)
    return Score(len(right), len(table.changes) - len(right), len(said) - len(right), near)


def _near(table: Table, key: tuple[str, str, str], when: float) -> bool:
    times = sorted({row["time"] for row in table.rows if (row["arm"], row["effect"], row["joint"]) == key})
    before, after = table.changes[key]
    low = max([t for t in times if t < before], default=before)
    high = min([t for t in times if t > after], default=after)
    return bool(low <= when <= high)
