"""The page, from the fleet to HTML. What comes from a recording or a list is escaped by the template."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

import trunk_ros.diagnosis.report as of_one
from trunk_ros import __version__
from trunk_ros.diagnosis.report.units import quantity, spoken
from trunk_ros.effects import effect
from trunk_ros.fleet.report.spark import spark
from trunk_ros.fleet.together.common import FEW
from trunk_ros.fleet.together.correction import ALPHA
from trunk_ros.fleet.together.judged import LEAST, Judged
from trunk_ros.fleet.together.series import DAY, Key
from trunk_ros.fleet.together.summary import Change, Fleet, Trend, date
from trunk_ros.words import listed

FOLDERS = (Path(__file__).parent, Path(of_one.__file__).parent)
ROWS = 300  # of a table; the files have all
COLUMNS = 12  # effects that the map shows
HEATS = 5


@dataclass(frozen=True)
class Cell:
    """One arm and effect of the map: its size, on which joint, how it changes, and its colour 0 … 5."""

    text: str
    joint: str
    mark: str
    heat: int


def render(fleet: Fleet, reports: Mapping[str, str], model: str) -> str:
    """The whole page as text. ``reports``: address of each arm's own report, where there is one."""
    environment = Environment(
        loader=FileSystemLoader(FOLDERS), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.filters |= {"spoken": spoken, "number": number}
    return environment.get_template("fleet.html.j2").render(**content(fleet, reports), model=model)


def content(fleet: Fleet, reports: Mapping[str, str]) -> dict[str, Any]:
    """What the template fills in."""
    series = {one.series.key: one for one in fleet.found}
    columns = effects_shown(fleet)
    return {
        "sentence": sentence(fleet),
        "reports": reports,
        "columns": columns,
        "map": [(arm, fleet.arms[arm], _cells(fleet, arm, columns)) for arm in _order(fleet)[:ROWS]],
        "arms": len(fleet.arms),
        "trends": _trends(fleet, series)[:ROWS],
        "changes": [_change(each, series) for each in sorted(fleet.changes, key=lambda c: c.time)][:ROWS],
        "common": [_common(each) for each in fleet.common],
        "own": [_own(each) for each in sorted(fleet.own, key=lambda o: o.chance)][:ROWS],
        "unread": fleet.unread[:ROWS],
        "left_out": max(len(fleet.unread) - ROWS, 0),
        "looked_at": fleet.looked_at,
        "least": LEAST,
        "few": FEW,
        "judged": len(fleet.arms) - len(fleet.short),
        "short": [(arm, fleet.arms[arm], _alone(fleet, arm)) for arm in fleet.short[:ROWS]],
        "short_left": max(len(fleet.short) - ROWS, 0),
        "alpha": f"{ALPHA:g}",
        "version": __version__,
    }


def sentence(fleet: Fleet) -> str:
    """The fleet in one sentence."""
    growing = {each.arm for each in fleet.trends}
    changed = {each.arm for each in fleet.changes}
    own = {each.arm for each in fleet.own}
    parts = [f"{number(len(fleet.arms), 'arm')}, {number(sum(fleet.arms.values()), 'recording')}"]
    if len(fleet.short) < len(fleet.arms):
        parts += [
            f"something grows on {len(growing)}" if growing else "nothing grows",
            f"something jumped on {len(changed)}" if changed else "nothing jumped",
        ]
    else:
        parts += [f"effects found on {len(fleet.alone)}" if fleet.alone else "no effects found"]
        parts += [f"something jumped on {len(changed)}"] if changed else []
    if fleet.short:
        parts += [f"too few recordings of {len(fleet.short)} to judge what grows (fewer than {LEAST})"]
    parts += [f"{len(own)} stand{'s' * (len(own) == 1)} out from the others"] if own else []
    unread = len(fleet.unread)
    parts += [f"{number(unread, 'recording')} could not be diagnosed"] if unread else []
    return f"{parts[0]}: {', '.join(parts[1:])}."


def number(count: int, what: str) -> str:
    """``1 arm``, ``2 arms``."""
    return f"{count} {what}{'s' * (count != 1)}"


def _alone(fleet: Fleet, arm: str) -> str:
    """What an arm's recordings show one by one, in words."""
    said = fleet.alone.get(arm, [])
    return ", ".join(
        f"{spoken(effect)} on {'the whole arm' if joint == 'arm' else joint} ({count})"
        for effect, joint, count in said
    )


def effects_shown(fleet: Fleet) -> list[tuple[str, str]]:
    """Effects and parameters of the map: those of most arms first."""
    arms: dict[tuple[str, str], set[str]] = {}
    for one in fleet.found:
        arms.setdefault((one.series.key.effect, one.series.key.parameter), set()).add(one.series.key.arm)
    return sorted(arms, key=lambda what: (-len(arms[what]), what))[:COLUMNS]


def _order(fleet: Fleet) -> list[str]:
    """Arms with something to say first."""
    said = [*(t.arm for t in fleet.trends), *(c.arm for c in fleet.changes), *(o.arm for o in fleet.own)]
    return sorted(fleet.arms, key=lambda arm: (-said.count(arm), arm))


def _cells(fleet: Fleet, arm: str, columns: list[tuple[str, str]]) -> list[Cell | None]:
    return [_cell(fleet, arm, name, parameter) for name, parameter in columns]


def _cell(fleet: Fleet, arm: str, name: str, parameter: str) -> Cell | None:
    """The joint on which an effect is largest."""
    alike = [
        one for one in fleet.found if (one.series.key.effect, one.series.key.parameter) == (name, parameter)
    ]
    mine = [one for one in alike if one.series.key.arm == arm]
    if not mine:
        return None
    null = effect(name).null()[parameter]
    largest = max(mine, key=lambda one: abs(one.level[0] - null))
    top = max(abs(one.level[0] - null) for one in alike) or 1.0
    size, std = largest.level
    heat = int(np.ceil(HEATS * abs(size - null) / top)) if abs(size - null) > 2.0 * std else 0
    text = quantity(size, std, largest.series.unit, relative=largest.series.unit == "1")
    shown = largest.series.key.joint
    said = (("grows", fleet.trends), ("jumped", fleet.changes))
    told = [_mark(word, shown, _joints(some, arm, name, parameter)) for word, some in said]
    return Cell(text, shown, ", ".join(filter(None, told)), heat)


def _joints(some: Sequence[Trend | Change], arm: str, name: str, parameter: str) -> list[str]:
    """The joints of an arm on which a value grows, or jumped."""
    mine = [one.joint for one in some if (one.arm, one.effect, one.parameter) == (arm, name, parameter)]
    return list(dict.fromkeys(mine))


def _mark(word: str, shown: str, joints: list[str]) -> str:
    """What a value does; with the joints where that is not the one that is shown alone."""
    if not joints:
        return ""
    return word if joints == [shown] else f"{listed(joints)} {word}"


def _trends(fleet: Fleet, series: dict[Key, Judged]) -> list[dict[str, Any]]:
    """One row for what grows, over days and over metres."""
    out: dict[Key, dict[str, Any]] = {}
    for each in fleet.trends:
        key = Key(each.arm, each.effect, each.joint, each.parameter)
        row = out.setdefault(key, _where(each) | {"day": "", "m": "", "crosses": "", "chance": each.chance})
        row[each.per] = _slope(each)
        if each.per == "day":
            row["since"] = day(each.since)
            row["now"] = quantity(each.now, None, each.unit, relative=each.unit == "1")
            row["spark"] = spark(series[key])
            row["crosses"] = _crosses(each)
    return sorted(out.values(), key=lambda row: row["chance"])


def _slope(each: Trend) -> str:
    """A slope with half the width of its interval, for the middle of which it stands."""
    half = (each.interval[1] - each.interval[0]) / 2
    return quantity(each.slope, half, each.unit, relative=each.unit == "1")


def _crosses(each: Trend) -> str:
    if each.limit is None or each.crosses is None:
        return ""
    when, first, last = each.crosses
    if when is None:
        return "never"
    sides = f"{day(first) if first else '…'} to {day(last) if last else 'never'}"
    return f"{day(when)} ({sides})"


def _change(each: Change, series: dict[Key, Judged]) -> dict[str, Any]:
    drawn = series.get(Key(each.arm, each.effect, each.joint, each.parameter))
    return _where(each) | {
        "day": day(each.time),
        "std": span(each.std),
        "step": quantity(each.step, each.step_std, each.unit, relative=each.unit == "1"),
        "spark": spark(drawn) if drawn else "",
    }


def _where(each: Any) -> dict[str, Any]:
    return {"arm": each.arm, "effect": each.effect, "joint": each.joint, "parameter": each.parameter}


def _common(each: Any) -> dict[str, Any]:
    half = (each.interval[1] - each.interval[0]) / 2
    relative = each.unit == "1"
    return {
        "effect": each.effect, "joint": each.joint, "parameter": each.parameter,
        "value": quantity(each.value, half, each.unit, relative=relative),
        "spread": quantity(each.spread, None, each.unit, relative=relative),
        "arms": f"{each.arms} of {each.of}",
    }  # fmt: skip


def _own(each: Any) -> dict[str, Any]:
    relative = each.unit == "1"
    return _where(each) | {
        "value": quantity(each.value, each.std, each.unit, relative=relative),
        "others": quantity(each.others, None, each.unit, relative=relative) if each.others else "nothing",
    }


def day(seconds: float) -> str:
    """A day as one writes it; the seconds themselves where no calendar has it."""
    told = date(seconds)
    return told[:10] if told else f"{seconds:.0f} s"


def span(seconds: float) -> str:
    """A time in days, hours or seconds."""
    if seconds >= DAY:
        return f"{seconds / DAY:.1f} days"
    return f"{seconds / 3600:.1f} h" if seconds >= 3600 else f"{seconds:.1f} s"
