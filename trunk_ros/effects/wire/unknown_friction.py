"""Friction in the wire that no name fits."""

from dataclasses import replace
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.curve import RANGE, VALUES, Curve
from trunk_ros.effects.effect import Now

TYPICAL = 2e-4  # rad, less than the dead bands that it adds to or takes from


class UnknownFriction(Curve):
    """w += curve(x), x being position (ratio phi), speed, time, load or another joint's angle;
    straight beyond its ends, over time held; w is never less than nothing.
    """

    id = "unknown_friction"
    stage = "wire"
    place = 100
    signature = "The backlash at a reversal depends on something in a way that no named effect has."
    regime = "reversal"
    parameters = (*RANGE, *(replace(p, typical=TYPICAL) for p in VALUES))
    of = "the dead band"
    confused_with = (
        ("load_dependent_friction", "reach one posture under different loads"),
        ("unknown", "pass one place in both directions: friction changes its sign"),
    )

    @classmethod
    def over(cls, variables: list[str], own: list[str]) -> list[str]:
        return own

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x, None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y, None

    def adjust(self, core: Core, now: Now) -> None:
        core.width = np.maximum(core.width + self._curve(now), 0.0)
