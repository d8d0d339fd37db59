"""A diagnosis against another simulator, and what a simulation has too much of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.diagnosis.verdict.findings import statement_of
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.effects import Effect, effect
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.curve import Curve
from trunk_ros.levels import SURE
from trunk_ros.model import Model
from trunk_ros.parameter import leading


def told_as_differences(result: Diagnosis, simulator: Model, of_simulator: Diagnosis) -> Diagnosis:
    """The diagnosis with what the simulator has itself."""
    has = {
        "has": [said for f in of_simulator.findings if (said := known_of(f))],
        "verdict": of_simulator.verdict,
        "findings": [asdict(f) for f in of_simulator.findings],
    }
    return replace(result, simulation=has, simulator=simulator)


def known_of(finding: Finding) -> str:
    """The statement of a finding with the sizes that are known apart from nothing; "" where none is."""
    kind = effect(finding.effect) if finding.named else None
    if kind is None or issubclass(kind, Curve | Bank):
        return finding.statement
    form = finding.evidence["form"]
    own = kind.own_parameters(form)
    sizes = {leading(own).name, *kind.sizes}
    known: dict[str, dict[str, dict[str, Any]]] = {}
    for owner, values in finding.parameters.items():
        named = {name: value for name, value in values.items() if _is_apart(kind, name, value)}
        if sizes & named.keys() or not sizes & values.keys():
            known[owner] = named
    if known == finding.parameters:
        return finding.statement
    if not any(sizes & values.keys() for values in known.values()):
        return ""
    joints = [joint for joint in finding.joints if joint in known or joint not in finding.parameters]
    return statement_of(kind.title(form), ", ".join(joints) or "the arm", known)


def _is_apart(kind: type[Effect], name: str, value: Mapping[str, Any]) -> bool:
    """Whether a value is surely not the one of no such effect, where there is one: of times there is none."""
    parameter = next((each for each in kind.parameters if each.name == name), None)
    if parameter is None or parameter.scale != "linear" or value["std"] is None:
        return True
    return bool(abs(value["value"] - parameter.absent) > SURE * value["std"])


def is_excess(finding: Finding) -> bool:
    """Whether a simulation has more of an effect than the recording shows, wherever the two differ."""
    told = [
        (effect(finding.effect).parameter(name).null, value)
        for named in finding.parameters.values()
        for name, value in named.items()
        if "simulation" in value
    ]
    return bool(told) and all(abs(v["recording"] - null) < abs(v["simulation"] - null) for null, v in told)
