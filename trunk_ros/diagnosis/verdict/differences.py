"""Findings as differences to another simulator, or to a model that has effects: what is missing in it, and
what is too much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from trunk_ros.diagnosis.evidence.evidence import SUREST
from trunk_ros.diagnosis.levels import ROUGH, SURE
from trunk_ros.diagnosis.verdict.answer import STAGES
from trunk_ros.diagnosis.verdict.finding import Finding, evidence_of
from trunk_ros.diagnosis.verdict.findings import ARM, VARIES_WITH, title, unchanged
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.diagnosis.verdict.units import unit_of
from trunk_ros.effect_values import Values
from trunk_ros.effects import Effect, effect
from trunk_ros.model import Model
from trunk_ros.parameter import Parameter

SIMULATION = "your simulation"
SMALL = {"rad": (1e3, "mrad"), "m": (1e3, "mm"), "s": (1e3, "ms")}


def told_as_differences(result: Diagnosis, simulator: Model, of_simulator: Diagnosis) -> Diagnosis:
    """The diagnosis with what the simulator has itself taken off its findings."""
    has = {
        "has": [f.statement for f in of_simulator.findings],
        "verdict": of_simulator.verdict,
        "findings": [asdict(f) for f in of_simulator.findings],
    }
    told = _told(result, simulator, SIMULATION, STAGES)
    return replace(result, findings=told, simulation=has, simulator=simulator)


def told_as_changes(result: Diagnosis, model: Model) -> Diagnosis:
    """The diagnosis with what differs from a model that has effects already, and which of them the recordings
    do not show: their values stay those of the arm.
    """
    told = _told(result, model, "the model", ("servo", "wire"))
    sure = {f.effect for f in told if f.effect in model.effects and not f.equivalents}
    motions = [e for e in result.experiments if e["separates"][0] not in sure]
    return replace(result, findings=told, experiments=motions)


def _told(result: Diagnosis, reference: Model, who: str, stages: Sequence[str]) -> list[Finding]:
    """Findings, those on effects that a reference has as differences from it."""
    had = {n: v for n, v in reference.effects.items() if effect(n).named and _is_compared(result, n, stages)}
    changed = [change for n, v in had.items() if (change := _difference(result, reference, n, v, who))]
    left = [f for f in result.findings if f.effect not in had]
    return sorted([*left, *changed], key=lambda f: STAGES.index(f.stage))


def _is_compared(result: Diagnosis, name: str, stages: Sequence[str]) -> bool:
    stage = effect(name).stage
    return stage in stages and bool(result.stages.get(stage, {}).get("compared"))


def is_excess(finding: Finding) -> bool:
    """Whether a simulation has more of an effect than the recording shows, wherever the two differ."""
    told = [
        (effect(finding.effect).parameter(name).null, value)
        for named in finding.parameters.values()
        for name, value in named.items()
        if "simulation" in value
    ]
    return bool(told) and all(abs(v["recording"] - null) < abs(v["simulation"] - null) for null, v in told)


def _difference(result: Diagnosis, reference: Model, name: str, known: Values, who: str) -> Finding | None:
    """The finding on one effect that a reference has, if the recording shows more or less of it."""
    kind, seen = effect(name), result.model.effects.get(name, {})
    found = next((f for f in result.findings if f.effect == name), None)
    lead, *others = kind.own_parameters(str(known.get("form", kind.forms[0])))
    had, there = _by_owner(reference, known, lead), _by_owner(result.model, seen, lead)
    stds = {o: told.get(lead.name, {}).get("std") for o, told in found.parameters.items()} if found else {}
    none = {o for o in had if _is_none(there[o] - lead.null, had[o], stds.get(o))}
    if found and (seen.get("form") != known.get("form") or _has_more(found, known)) and len(none) < len(had):
        return found
    parameters: dict[str, dict[str, dict[str, Any]]] = {}
    said: list[str] = []
    for owner in (*result.stages[kind.stage].get("joints", result.model.arm.joints), ARM):
        told = dict(found.parameters.get(owner, {})) if found else {}
        std, words = stds.get(owner), []
        if owner in had and not unchanged({"value": there[owner], "std": std}, had[owner]):
            unit = unit_of(lead.unit, told.get(lead.name, {}).get("unit", "rad"))
            apart = lead.null == 0.0 and who == SIMULATION
            size = there[owner] - had[owner] if apart else there[owner]
            told = {} if owner in none else told
            told[lead.name] = {
                "value": size, "std": std, "unit": unit, "simulation": had[owner], "recording": there[owner]
            }  # fmt: skip
            words = [_said(lead, unit, had[owner], lead.null if owner in none else there[owner], who)]
        for other in (p for p in others if p.name in told):
            theirs, value = _by_owner(reference, known, other).get(owner), told[other.name]
            if theirs is not None and not unchanged(value, theirs):
                words.append(f"{other.name} {_said(other, value['unit'], theirs, value['value'], who)}")
        if words:
            parameters[owner] = told
            said.append(f"{owner}: {', '.join(words)}")
    if not parameters:
        return None
    joints = [j for j in result.model.arm.joints if j in parameters]
    joints = joints or (found.joints if found else list(result.stages[kind.stage].get("joints", [])))
    statement = f"{title(kind)[0].lower()}{title(kind)[1:]}: {'; '.join(said)}."
    base = _unseen(kind, SUREST) if found is None or none.issuperset(parameters) else found
    return replace(base, joints=joints, parameters=parameters, statement=statement)


def _is_none(value: float, theirs: float, std: float | None) -> bool:
    """Whether a value is none, beside what a reference has."""
    return abs(value) <= max(ROUGH * abs(theirs), SURE * (std or 0.0))


def _has_more(found: Finding, known: Values) -> bool:
    """Whether a finding has values of a kind that a reference has none of, such as a moment or a source."""
    return any(name not in known for named in found.parameters.values() for name in named)


def _by_owner(model: Model, values: Values, lead: Parameter) -> dict[str, float]:
    """A parameter by joint, or under "arm" where all joints share it."""
    given = values.get(lead.name, lead.null)
    if lead.shared:
        return {ARM: float(np.asarray(given))}
    spread = np.broadcast_to(np.asarray(given, dtype=float), (len(model.arm.joints),))
    return dict(zip(model.arm.joints, spread.tolist(), strict=True))


def _said(parameter: Parameter, unit: str, theirs: float, seen: float, who: str) -> str:
    """What a reference has and what the recording shows, in words."""
    if seen == parameter.null:
        return f"{who} has {_sized(theirs, unit)}, the recording shows none"
    if theirs == parameter.null:
        return f"{who} has none, the recording shows {_sized(seen, unit)}"
    if parameter.null != 0.0 or theirs * seen < 0.0:
        word = "another value"
    else:
        more = abs(seen) > abs(theirs)
        word = f"{_sized(abs(seen - theirs), unit)} too {'little' if more else 'much'}"
    return f"{who} has {_sized(theirs, unit)}, the recording shows {_sized(seen, unit)} ({word})"


def _sized(value: float, unit: str) -> str:
    factor, name = SMALL.get(unit, (1.0, "" if unit == "1" else unit))
    return f"{value * factor:.3g} {name}".rstrip()


def _unseen(kind: type[Effect], confidence: float) -> Finding:
    """A finding on an effect that the recording does not show at all."""
    evidence = evidence_of(signature=kind.signature, form=kind.forms[0])
    return Finding(
        kind.id, kind.stage, [], kind.regime, confidence, [], {}, list(VARIES_WITH[kind.regime]), "", evidence
    )
