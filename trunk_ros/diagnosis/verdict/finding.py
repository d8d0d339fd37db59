"""One effect that was found, in the words of ``diagnosis.json``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from trunk_ros.effects.wire.unknown import Unknown

UNKNOWN = Unknown.id  # what a finding is called that no name fits, in any stage


def evidence_of(strength: float = 0.0, signature: str = "", **more: Any) -> dict[str, Any]:
    """What speaks for a finding, in the words of ``diagnosis.json``; by default nothing does."""
    nothing: dict[str, Any] = {"gain": {}, "rivals": {}, "form": ""}
    return {"strength": strength, **nothing, "signature": signature, **more}


@dataclass
class Finding:
    """One effect that the recordings show and the simulation leaves out; see docs for the JSON."""

    effect: str
    stage: str
    joints: list[str]
    regime: str
    confidence: float
    equivalents: Sequence[str | list[str]]
    parameters: dict[str, dict[str, dict[str, Any]]]
    depends_on: list[str]
    statement: str
    evidence: dict[str, Any]
    curve: dict[str, Any] = field(default_factory=dict)

    @property
    def named(self) -> bool:
        """Whether it is an effect that has a name."""
        return self.effect != UNKNOWN

    @property
    def candidates(self) -> list[str]:
        """The effect, whose values the model has, and its equivalents: ``confidence`` is about them all."""
        return [self.effect, *(one if isinstance(one, str) else " + ".join(one) for one in self.equivalents)]
