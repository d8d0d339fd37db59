"""What the page says of each finding: values, evidence, rivals."""

from __future__ import annotations

import math
from typing import Any

from trunk_ros.data.noise import is_none, rms
from trunk_ros.diagnosis.report.signals import acts, concerns, contributions, entries, signals
from trunk_ros.diagnosis.report.signature import figure_signature, reading
from trunk_ros.diagnosis.report.style import image
from trunk_ros.diagnosis.report.units import powers, quantity, rounded, spoken, times
from trunk_ros.diagnosis.report.verdict import place
from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.diagnosis.verdict.differences import is_excess
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effects import effect, registry
from trunk_ros.own_time import TIME
from trunk_ros.units import UNTOLD, is_open
from trunk_ros.words import listed

OWN_TIME = " It was seen in this recording: whether another one repeats it is not known."
ALL = "arm"  # owner of shared values
FEW = 8  # lines of a list


def card(result: Answer, finding: Finding) -> dict[str, Any]:
    """What the template shows of a finding, beside the finding."""
    figure = figure_signature(result, finding)
    samples = samples_of(result, finding)
    gain = sum(float(g) for g in finding.evidence.get("gain", {}).values())
    quiet = without_noise(result, finding) or not acts(finding)
    return {
        "name": spoken(finding.effect),
        "title": ("less " if is_excess(finding) else "")
        + listed([spoken(name) for name in finding.candidates], "or"),
        "statement": statement(finding),
        "narrow": figure is not None and len(figure.axes) == 1,
        "where": place(result, finding.stage, finding.joints) or "the arm",
        "image": None if figure is None else image(figure),
        "reading": reading(result, finding),
        "parameters": table(finding),
        "sizes": sizes(finding) if acts(finding) else ["no curve fits"],
        "confidence": round(100 * finding.confidence),
        "strength": "" if quiet else times(float(finding.evidence.get("strength", 0.0))),
        "does": does(result, finding) if figure is not None and acts(finding) else "",
        "ties": ties(finding),
        "at_bound": at_bound(finding),
        "gain": "" if quiet else per_sample(gain, samples),
        "rivals": rivals(finding, 0 if quiet else samples),
        "equivalents": [spoken(name) for name in finding.equivalents],
    }


def without_noise(result: Answer, finding: Finding) -> bool:
    """Whether a finding is on signals without noise alone: nothing is told in times of that."""
    mine = [s for name, s in entries(result, finding.stage).items() if concerns(finding, finding.stage, name)]
    return bool(mine) and all(is_none(float(said.get("noise_floor") or 0.0)) for said in mine)


def statement(finding: Finding) -> str:
    """What a finding says, without the values that the table gives."""
    for owner, held in finding.parameters.items():
        for name in held:
            head, values, _ = finding.statement.partition(f" ({owner} {name} ")
            if values:
                return head + "."
    if not finding.named and finding.curve.get("on") == TIME:
        return finding.statement + OWN_TIME
    return finding.statement


def table(finding: Finding) -> dict[str, Any]:
    """Values with spreads: a column per parameter, a row per joint, shared values in a row of their own."""
    names = list(dict.fromkeys(name for held in finding.parameters.values() for name in held))
    rows = [
        (
            "shared" if owner == ALL else owner,
            [_value(finding, name, held.get(name)) for name in names],
        )
        for owner, held in sorted(finding.parameters.items(), key=lambda item: item[0] == ALL)
    ]
    return {"names": [(spoken(name), _meaning(finding.effect, name)) for name in names], "rows": rows}


def _value(finding: Finding, name: str, held: dict[str, Any] | None) -> str:
    if held is None:
        return ""
    kind, unit = registry().get(finding.effect), held.get("unit") or "1"
    relative = kind is not None and any(p.relative for p in kind.parameters if p.name == name)
    return (
        UNTOLD
        if is_open({"unit": unit, **held})
        else quantity(held.get("value"), held.get("std"), unit, relative)
    )


def _meaning(name: str, parameter: str) -> str:
    kind = registry().get(name)
    known = {p.name: p.meaning for p in (*kind.parameters, *kind.moments())} if kind else {}
    return known.get(parameter, "")


def sizes(finding: Finding) -> list[str]:
    """A value of each joint in a few words, for the list at the top, or what all share."""
    told = {owner: _telling(finding, held) for owner, held in finding.parameters.items()}
    of_joints = {owner: text for owner, text in told.items() if text and owner != ALL}
    kept = of_joints or {owner: text for owner, text in told.items() if text}
    if len(kept) == 1:
        return list(kept.values())
    more = ["…"] if len(kept) > FEW else []
    return [f"{owner}: {text}" for owner, text in list(kept.items())[:FEW]] + more


def _telling(finding: Finding, held: dict[str, dict[str, Any]]) -> str:
    """The first value with a spread that is less, else the first that is a number; "" where none is."""
    numbers = [name for name, said in held.items() if not isinstance(said.get("value"), str)]
    sure = [n for n in numbers if held[n].get("std") is not None and not is_open(held[n])]
    name = next(iter([*sure, *numbers]), None)
    return "" if name is None else f"{spoken(name)} {_value(finding, name, held[name])}"


def does(result: Answer, finding: Finding) -> str:
    """What it does to its signals, rms of the largest, in a unit."""
    mine = contributions(result, finding)
    held = {s.name: s for s in signals(result) if s.name in mine and concerns(finding, s.stage, s.name)}
    sizes = {
        s.unit: max(rms(mine[n][s.valid]) for n, s in held.items() if s.valid.any())
        for s in held.values()
        if s.valid.any()
    }
    return listed([rounded(size, unit) for unit, size in sizes.items() if size > 0.0])


def ties(finding: Finding) -> list[str]:
    """Values that the data tell together better than each."""
    return [
        f"{_at(finding, one['first'])} and {_at(finding, one['second'])}: {one['value']:+.2f}".replace(
            "-", "−"
        )
        for one in finding.evidence.get("correlations", ())[:FEW]
    ]


def at_bound(finding: Finding) -> list[str]:
    """Values at a bound of what is believed possible."""
    return [
        f"{_at(finding, one['place'])}, {one['side']} bound {quantity(one['bound'], None, one['unit'])}"
        for one in finding.evidence.get("at_bound", ())
    ]


def _at(finding: Finding, place: dict[str, str]) -> str:
    """A value's name; with its effect where that is another one."""
    other = "" if place["effect"] == finding.effect else f"{spoken(place['effect'])} "
    return f"{other}{spoken(place['parameter'])} ({'shared' if place['joint'] == ALL else place['joint']})"


def samples_of(result: Answer, finding: Finding) -> int:
    """Samples that a finding was judged on: those of the first recording, times how much there is of all."""
    first = sum(int(s.valid.sum()) for s in signals(result) if concerns(finding, s.stage, s.name))
    key = {"servo": "gearbox_states", "wire": "joint_states"}.get(finding.stage, "joint_states")
    counts = [q.get("topics", {}).get(key, {}).get("samples", 0) for q in result.quality.values()]
    return round(first * sum(counts) / counts[0]) if counts and counts[0] else first


def per_sample(loss: float, samples: int) -> str:
    """Squared noise units per sample; empty where the samples are not known."""
    return powers(loss / samples) if samples else ""


def rivals(finding: Finding, samples: int) -> list[dict[str, Any]]:
    """Effects that were put in its place, the nearest first, and by how much worse they explain the data."""
    gain = sum(float(g) for g in finding.evidence.get("gain", {}).values())
    near = sorted(finding.evidence.get("rivals", {}).items(), key=lambda item: float(item[1]))
    return [
        {
            "name": spoken(name),
            "loss": per_sample(float(loss), samples),
            "why": _as_well(float(loss)) if name in finding.equivalents else _why(name, loss, gain),
        }
        for name, loss in near
    ]


def _as_well(loss: float) -> str:
    return f"explains these data {'better' if loss < 0.0 else 'as well'}"


def _why(name: str, loss: float, gain: float) -> str:
    """How much of what there is to explain a rival explains, and what would be seen if it were true."""
    share = min(max(1.0 - float(loss) / gain, 0.0), 0.9999) if gain > 0.0 else 0.0
    head = f"explains {math.floor(1000 * share) / 10:g} %" if share > 0.005 else "explains none of it"
    if name not in registry():
        return head
    text = effect(name).signature.rstrip(".")
    return f"{head}; would show: {text[0].lower()}{text[1:]}"
