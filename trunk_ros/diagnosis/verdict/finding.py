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
        """The effect and its equivalents, which ``confidence`` is about together; those that fit the data
        better than the effect come first.
        """
        losses = self.evidence.get("rivals", {})
        words = {name if isinstance(name, str) else " + ".join(name): name for name in self.equivalents}
        better = [
            word for word, name in words.items() if isinstance(name, str) and losses.get(name, 0.0) < 0.0
        ]
        return [*better, self.effect, *(word for word in words if word not in better)]
