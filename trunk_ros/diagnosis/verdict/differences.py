"""Findings as differences to another simulator: what is missing in it, and what is too much."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from trunk_ros.diagnosis.evidence.evidence import SUREST
from trunk_ros.diagnosis.levels import ROUGH
from trunk_ros.diagnosis.verdict.finding import Finding, evidence_of
from trunk_ros.diagnosis.verdict.findings import ARM, VARIES_WITH, title, unchanged
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.diagnosis.verdict.units import unit_of
from trunk_ros.effect_values import Values
from trunk_ros.effects import Effect, effect
from trunk_ros.model import Model
from trunk_ros.parameter import Parameter

SMALL = {"rad": (1e3, "mrad"), "m": (1e3, "mm"), "s": (1e3, "ms")}


def told_as_differences(result: Diagnosis, simulator: Model, of_simulator: Diagnosis) -> Diagnosis:
    """The diagnosis with what the simulator has itself taken off its findings."""
    named = [f for f in result.findings if f.effect not in simulator.effects]
    for name, known in simulator.effects.items():
        if effect(name).named and result.stages.get(effect(name).stage, {}).get("compared"):
            named += _difference(result, simulator, name, known)
    has = {
        "has": [f.statement for f in of_simulator.findings],
        "verdict": of_simulator.verdict,
        "findings": [asdict(f) for f in of_simulator.findings],
    }
    return replace(result, findings=named, simulation=has, simulator=simulator)


def is_excess(finding: Finding) -> bool:
    """Whether another simulator has more of an effect than the recording shows, wherever the two differ."""
    told = [v for named in finding.parameters.values() for v in named.values() if "simulation" in v]
    return bool(told) and all(abs(v["recording"]) < abs(v["simulation"]) for v in told)


def _difference(result: Diagnosis, simulator: Model, name: str, known: Values) -> Iterator[Finding]:
    """The finding on one effect that the simulator has, if the recording shows more or less of it."""
    kind, model = effect(name), result.model
    found = next((f for f in result.findings if f.effect == name), None)
    lead = kind.own_parameters(str(known.get("form", kind.forms[0])))[0]
    theirs, seen = (
        _by_owner(m, values, lead) for m, values in ((simulator, known), (model, model.effects.get(name, {})))
    )
    parameters: dict[str, dict[str, dict[str, Any]]] = {}
    said = []
    for owner in theirs:
        told = dict(found.parameters.get(owner, {})) if found else {}
        std = told.get(lead.name, {}).get("std")
        if unchanged({"value": seen[owner], "std": std}, theirs[owner]):
            continue
        unit = unit_of(lead.unit, told.get(lead.name, {}).get("unit", "rad"))
        value = seen[owner] - theirs[owner] if lead.null == 0.0 else seen[owner]
        told[lead.name] = {
            "value": value, "std": std, "unit": unit, "simulation": theirs[owner], "recording": seen[owner]
        }  # fmt: skip
        parameters[owner] = told
        said.append(_said(owner, lead, unit, theirs[owner], seen[owner]))
    if not parameters:
        return
    joints = [j for j in model.arm.joints if j in parameters] or (
        found.joints if found else list(model.arm.joints)
    )
    statement = f"{title(kind)[0].lower()}{title(kind)[1:]}: {'; '.join(said)}."
    base = found or _unseen(kind, SUREST)
    yield replace(base, joints=joints, parameters=parameters, statement=statement)


def _by_owner(model: Model, values: Values, lead: Parameter) -> dict[str, float]:
    """A parameter by joint, or under "arm" where all joints share it."""
    given = values.get(lead.name, lead.null)
    if lead.shared:
        return {ARM: float(np.asarray(given))}
    spread = np.broadcast_to(np.asarray(given, dtype=float), (len(model.arm.joints),))
    return dict(zip(model.arm.joints, spread.tolist(), strict=True))


def _said(owner: str, lead: Parameter, unit: str, theirs: float, seen: float) -> str:
    """What the simulator has and what the recording shows, in words."""
    if seen == lead.null or abs(seen) < ROUGH * abs(theirs):
        return f"{owner}: your simulation has {_sized(theirs, unit)}, the recording shows none"
    if theirs == lead.null:
        return f"{owner}: your simulation has none, the recording shows {_sized(seen, unit)}"
    if lead.null != 0.0 or theirs * seen < 0.0:
        word = "another value"
    else:
        more = abs(seen) > abs(theirs)
        word = f"{_sized(abs(seen - theirs), unit)} too {'little' if more else 'much'}"
    both = f"your simulation has {_sized(theirs, unit)}, the recording shows {_sized(seen, unit)}"
    return f"{owner}: {both} ({word})"


def _sized(value: float, unit: str) -> str:
    factor, name = SMALL.get(unit, (1.0, "" if unit == "1" else unit))
    return f"{value * factor:.3g} {name}".rstrip()


def _unseen(kind: type[Effect], confidence: float) -> Finding:
    """A finding on an effect that the recording does not show at all."""
    evidence = evidence_of(signature=kind.signature, form=kind.forms[0])
    return Finding(
        kind.id, kind.stage, [], kind.regime, confidence, [], {}, list(VARIES_WITH[kind.regime]), "", evidence
    )
