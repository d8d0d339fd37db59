"""What the page says of each finding: values, evidence, rivals."""

from __future__ import annotations

import math
from typing import Any

from trunk_ros.diagnosis.report.signals import concerns, signals
from trunk_ros.diagnosis.report.signature import figure_signature, reading
from trunk_ros.diagnosis.report.style import image
from trunk_ros.diagnosis.report.units import powers, quantity, spoken, times
from trunk_ros.diagnosis.report.verdict import place
from trunk_ros.diagnosis.verdict.result import Diagnosis, Finding
from trunk_ros.effects import effect, registry

ALL = "arm"  # owner of shared values
FEW = 3


def cards(result: Diagnosis) -> list[dict[str, Any]]:
    """One dictionary per finding, for the template."""
    return [_card(result, finding) for finding in result.findings]


def _card(result: Diagnosis, finding: Finding) -> dict[str, Any]:
    figure = figure_signature(result, finding)
    samples = samples_of(result, finding)
    gain = sum(float(g) for g in finding.evidence.get("gain", {}).values())
    return {
        "name": spoken(finding.effect),
        "finding": finding,
        "statement": statement(finding),
        "narrow": figure is not None and len(figure.axes) == 1,
        "where": place(result, finding.stage, finding.joints) or "the arm",
        "image": None if figure is None else image(figure),
        "reading": reading(result, finding),
        "parameters": table(finding),
        "sizes": sizes(finding),
        "confidence": round(100 * finding.confidence),
        "strength": times(float(finding.evidence.get("strength", 0.0))),
        "gain": per_sample(gain, samples),
        "rivals": rivals(finding, samples),
        "equivalents": [spoken(name) for name in finding.equivalents],
    }


def statement(finding: Finding) -> str:
    """What a finding says, without the values that the table gives."""
    for owner, held in finding.parameters.items():
        for name in held:
            head, values, _ = finding.statement.partition(f" ({owner} {name} ")
            if values:
                return head + "."
    return finding.statement


def table(finding: Finding) -> dict[str, Any]:
    """Values with spreads: a column per parameter, a row per joint, shared values in a row of their own."""
    names = list(dict.fromkeys(name for held in finding.parameters.values() for name in held))
    rows = [
        ("shared" if owner == ALL else owner, [_value(name, held.get(name)) for name in names])
        for owner, held in sorted(finding.parameters.items(), key=lambda item: item[0] == ALL)
    ]
    return {"names": [(spoken(name), _meaning(finding.effect, name)) for name in names], "rows": rows}


def _value(name: str, held: dict[str, Any] | None) -> str:
    if held is None:
        return ""
    return quantity(held.get("value"), held.get("std"), held.get("unit") or "1", name == "relative")


def _meaning(name: str, parameter: str) -> str:
    kind = registry().get(name)
    known = {p.name: p.meaning for p in kind.parameters} if kind else {}
    return known.get(parameter, "")


def sizes(finding: Finding) -> str:
    """The first value of each joint in a few words, for the list at the top."""
    kept = []
    for owner, held in finding.parameters.items():
        name = next((n for n, v in held.items() if not isinstance(v.get("value"), str)), None)
        if name is not None:
            text = _value(name, held[name])
            kept.append((owner, f"{spoken(name)} {text}"))
    shared = [text for owner, text in kept if owner == ALL]
    own = [text if len(kept) == 1 else f"{owner}: {text}" for owner, text in kept]
    return "; ".join(shared or own[:FEW]) + (" …" if not shared and len(own) > FEW else "")


def samples_of(result: Diagnosis, finding: Finding) -> int:
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
            "why": "explains these data as well" if name in finding.equivalents else _why(name, loss, gain),
        }
        for name, loss in near
    ]


def _why(name: str, loss: float, gain: float) -> str:
    """How much of what there is to explain a rival explains, and what would be seen if it were true."""
    share = min(max(1.0 - float(loss) / gain, 0.0), 0.9999) if gain > 0.0 else 0.0
    head = (
        f"explains {math.floor(1000 * share) / 10:g} % of it" if share > 0.005 else "explains nothing of it"
    )
    if name not in registry():
        return head
    text = effect(name).signature.rstrip(".")
    return f"{head}; would show: {text[0].lower()}{text[1:]}"
