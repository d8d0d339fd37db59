"""A diagnosis against another simulator, and what a simulation has too much of."""

from __future__ import annotations

from dataclasses import asdict, replace

from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.effects import effect
from trunk_ros.model import Model


def told_as_differences(result: Diagnosis, simulator: Model, of_simulator: Diagnosis) -> Diagnosis:
    """The diagnosis with what the simulator has itself."""
    has = {
        "has": [f.statement for f in of_simulator.findings],
        "verdict": of_simulator.verdict,
        "findings": [asdict(f) for f in of_simulator.findings],
    }
    return replace(result, simulation=has, simulator=simulator)


def is_excess(finding: Finding) -> bool:
    """Whether a simulation has more of an effect than the recording shows, wherever the two differ."""
    told = [
        (effect(finding.effect).parameter(name).null, value)
        for named in finding.parameters.values()
        for name, value in named.items()
        if "simulation" in value
    ]
    return bool(told) and all(abs(v["recording"] - null) < abs(v["simulation"] - null) for null, v in told)
