"""What is said of the findings of all stages together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from trunk_ros.arm import Arm
from trunk_ros.diagnosis.verdict.answer import STAGES
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.effects import effect

OF_THE_ROW = "The model tells by wire.coupling what moves {}: the entries of that row are off by as much."


def together(findings: Sequence[Finding], arm: Arm) -> list[Finding]:
    """Findings by stage; those that say other entries of ``wire.coupling``, where the arm has it, say so."""
    told = [_of_a_row(f) if arm.coupling is not None else f for f in findings]
    return sorted(told, key=lambda finding: STAGES.index(finding.stage))


def _of_a_row(finding: Finding) -> Finding:
    if not finding.named or not effect(finding.effect).in_coupling:
        return finding
    said = OF_THE_ROW.format(", ".join(finding.joints))
    return replace(finding, statement=f"{finding.statement} {said}")
