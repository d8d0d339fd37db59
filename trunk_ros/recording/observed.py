"""What a look at clocks and sensors has shown of a recording."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Observed:
    """What is no physics, on a topic and some of its joints; ``value`` in ``unit``, std where it has one.

    corrected: whether the recording was put right. looks_like: effects that it would have been taken for.
    """

    kind: str
    topic: str
    joints: tuple[str, ...]
    value: float
    std: float | None
    unit: str
    corrected: bool
    looks_like: tuple[str, ...]
    statement: str
