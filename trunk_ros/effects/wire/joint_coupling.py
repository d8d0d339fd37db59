"""Another joint's angle changes the path of this joint's wire."""

from functools import cached_property
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.errors import ModelError
from trunk_ros.parameter import Parameter

SOURCES = 3


def _gain(k: int) -> Parameter:
    name = "gain" if k == 1 else f"gain_{k}"
    return Parameter(
        name, "1", (-3.0, 3.0), "joint angle per angle of the source", typical=0.005, optional=k > 1
    )


class JointCoupling(Effect):
    """u += gain theta_source, for up to three sources a joint."""

    id = "joint_coupling"
    stage, place, regime = "wire", 30, "posture"
    signature = "The residual follows another joint's angle, whether this joint moves or not."
    source = "Ciofu & Stan, fig. 1: wires of distal joints pass through the guides of the proximal ones."
    parameters = tuple(_gain(k) for k in range(1, SOURCES + 1))
    texts = ("source", *(f"source_{k}" for k in range(2, SOURCES + 1)))
    needs = ("several",)
    confused_with = (
        ("load_elasticity", "hold this joint and turn others so that the arm's reach stays the same"),
    )

    _gains: Array | None = None
    """(all joints, columns) joint angle per angle of each source."""

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return x + self._pull(now), None

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        return y - self._pull(now), None

    def check(self, joints: tuple[str, ...]) -> None:
        super().check(joints)
        for gain, text in self.pairs():
            for column, (value, source) in enumerate(
                zip(self[gain], self.words.get(text, ("",) * len(joints)), strict=True)
            ):
                if value != 0.0 and (source not in joints or source == joints[column]):
                    others = ", ".join(joint for joint in joints if joint != joints[column])
                    raise ModelError(
                        f"effects.{self.id}.{text} of {joints[column]} is {source!r}: choose from {others}"
                    )

    def pairs(self) -> list[tuple[str, str]]:
        """Names of each gain and the source that belongs to it."""
        return [(p.name, text) for p, text in zip(self.parameters, self.texts, strict=True)]

    @cached_property
    def _links(self) -> list[tuple[int, str, float]]:
        """Column, source and gain of each coupling that there is."""
        return [
            (column, source, float(self[gain][column]))
            for gain, text in self.pairs()
            for column, source in enumerate(self.words.get(text, ()))
            if source and self[gain][column] != 0.0
        ]

    def _pull(self, now: Now) -> Array:
        """(n, columns) rad that the sources add."""
        if self._gains is None:
            self._gains = np.zeros((len(now.joints), len(now.ratio)))
            for column, source, gain in self._links:
                self._gains[now.joints.index(source), column] += gain
        return np.asarray(now.angles @ self._gains)
