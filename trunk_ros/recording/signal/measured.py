"""One measured quantity of a stage."""

from __future__ import annotations

from dataclasses import dataclass

from trunk_ros.compiled import Array


@dataclass(frozen=True)
class Measured:
    """A joint's angle or a coordinate of the tip: ``measured`` (n,), in ``unit``, at ``stamp`` (n,) s."""

    stage: str
    name: str
    unit: str
    stamp: Array
    measured: Array
