"""The dead band grows with the bend of another joint that the wire passes."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.sources import STANDS, check_sources
from trunk_ros.parameter import Parameter

SOURCES = 3


def _gain(k: int) -> Parameter:
    name = "gain" if k == 1 else f"gain_{k}"
    return Parameter(
        name, "1", (-1.0, 1.0), "half-width per angle of the source", typical=1e-3, optional=k > 1
    )


class WrapFriction(Effect):
    """w += gain abs(s) with s the angle of another joint, for up to three sources a joint: guides that are
    straight at its zero. turned: w += gain s, where the wire wraps them there already; w >= 0.
    """

    id = "wrap_friction"
    sizes = tuple(_gain(k).name for k in range(1, SOURCES + 1))
    stage, place, regime = "wire", 100, "reversal"
    signature = "Backlash that is wide where another joint is bent and narrow where it is straight."
    source = (
        "Euler-Eytelwein, T' = T'' exp(mu alpha) (Ciofu & Stan, eq. (1)), to first order in the wrap angle "
        "alpha, which grows as the joint bends whose guides the wire passes."
    )
    forms = ("bent", "turned")
    parameters = tuple(_gain(k) for k in range(1, SOURCES + 1))
    texts = ("source", *(f"source_{k}" for k in range(2, SOURCES + 1)))
    needs = ("several",)
    confused_with = (
        ("backlash", "reverse with the source straight and bent: a backlash stays the same"),
        ("load_dependent_friction", "reverse with the source bent to both sides, so that the load differs"),
    )

    def adjust(self, core: Core, now: Now) -> None:
        added = self._added(now)
        if added is not None:
            core.width = np.maximum(core.width + added, 0.0)

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Each source bends while this joint moves: else it is a backlash."""
        moves = np.any(now.speed != 0.0, axis=1)
        most = np.ptp(now.angles, axis=0).max()
        shown = [self._bend(now, s)[moves] for text in self.texts for s in self.words.get(text, ()) if s]
        return all(len(bend) > 0 and np.ptp(bend) > STANDS * most for bend in shown)

    def check(self, joints: tuple[str, ...]) -> None:
        super().check(joints)
        check_sources(self.id, zip(self.sizes, self.texts, strict=True), self.values, self.words, joints)

    def _added(self, now: Now) -> Array | None:
        """(n, columns) rad of half-width that the sources add, if any do."""
        out = None
        for parameter, text in zip(self.parameters, self.texts, strict=True):
            for column, source in enumerate(self.words.get(text, ())):
                if source and self[parameter.name][column] != 0.0:
                    out = np.zeros((len(now.stamp), len(now.ratio))) if out is None else out
                    out[:, column] += self[parameter.name][column] * self._bend(now, source)
        return out

    def _bend(self, now: Now, source: str) -> Array:
        """(n,) rad by which a source adds to the wrap angle."""
        angle = now.angles[:, now.joints.index(source)]
        return np.abs(angle) if self.form == "bent" else angle
