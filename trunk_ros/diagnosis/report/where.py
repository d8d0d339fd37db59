"""The map of where: each signal of each stage, its error in units of the noise, and what was found there."""

from __future__ import annotations

from dataclasses import dataclass

from trunk_ros.diagnosis.report.errors import ABOVE, Ratio, ratios
from trunk_ros.diagnosis.report.signals import concerns, entries, largest, mixed_up
from trunk_ros.diagnosis.report.units import fall, rounded, spoken, times
from trunk_ros.diagnosis.verdict.answer import Answer

HEAT = (ABOVE, 2.0, 4.0, 8.0, 16.0)  # times the noise, where the next shade begins
SILENT = "hardly moves or is hardly measured: nothing can be said"
MEANING = {"servo": "setpoint to gearbox", "wire": "gearbox to joint", "arm": "joint to tip"}


@dataclass(frozen=True)
class Cell:
    """One field of the map: ``heat`` 0 … 5, or -1 where there is nothing to compare."""

    heat: int
    text: str
    noise: str
    """The same in times the noise or the encoder's steps; empty where there is nothing to compare."""
    found: list[str]
    rest: bool = False
    of: str = "noise"


@dataclass(frozen=True)
class Map:
    """Stages as columns, signals as rows."""

    stages: list[tuple[str, str]]
    rows: list[tuple[str, list[Cell]]]


def maps(result: Answer) -> list[Map]:
    """One map of joints and, where the tip was compared, one of the tip."""
    compared = [s for s in MEANING if result.stages.get(s, {}).get("compared")]
    known = {(r.stage, r.name): r for r in ratios(result)}
    out = []
    for stages in (["servo", "wire"], ["arm"]):
        shown = [s for s in stages if s in compared]
        if shown:
            names = _names(result, shown)
            rows = [(n, [_cell(result, s, n, known.get((s, n))) for s in shown]) for n in names]
            out.append(Map([(s, MEANING[s]) for s in shown], rows))
    return out


def not_compared(result: Answer) -> list[str]:
    """Stages without a comparison, with what they would be and why there is none."""
    left = [s for s in MEANING if not result.stages.get(s, {}).get("compared")]
    mixed = mixed_up(result)
    why = {s: "mixed up, see above" if s in mixed else "topics or motion are missing" for s in left}
    return [f"{s} ({MEANING[s]}: {why[s]})" for s in left]


def _names(result: Answer, stages: list[str]) -> list[str]:
    names: dict[str, None] = {}
    if stages != ["arm"]:
        seen = {n for s in stages for n in [*entries(result, s), *result.stages[s].get("silent", [])]}
        names = dict.fromkeys(j for j in result.model.arm.joints if j in seen)
    for stage in stages:
        names |= dict.fromkeys([*entries(result, stage), *result.stages[stage].get("silent", [])])
    return list(names)


def _cell(result: Answer, stage: str, name: str, ratio: Ratio | None) -> Cell:
    found = [
        spoken(f.effect) + ("?" if f.equivalents else "") for f in result.findings if concerns(f, stage, name)
    ]
    said = entries(result, stage).get(name)
    if said is None:
        silent = name in result.stages[stage].get("silent", [])
        return Cell(-1, SILENT if silent else "not measured", "", found)
    rest = any(u.stage == stage and (name in u.joints or not u.joints) for u in result.unexplained)
    before, after = float(said["rmse_before"]), float(said["rmse_after"])
    changed = abs(after - before) > 0.05 * before
    unit = str(said.get("unit", "rad"))
    size = largest(result, stage, unit)
    text = fall(before, after, unit, size) if changed else rounded(before, unit, size)
    if stage == "arm" and not changed:  # a tip's coordinate that an arm effect leaves alone
        found = []
    if ratio is None:  # nothing to compare its size with
        return Cell(0, text, "", found, rest)
    noise = f"{times(ratio.before)} → {times(ratio.after)}" if changed else times(ratio.before)
    heat = sum(ratio.before > limit for limit in HEAT)
    return Cell(heat, text, noise, found, rest and ratio.after > ABOVE, ratio.of)
