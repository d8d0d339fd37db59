"""A wire that stretches before the friction, behind it, or in part on either side."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Self

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.swing import Transients
from trunk_ros.effects.wire.swinging_links import Links
from trunk_ros.parameter import Parameter

HELD = "held"
"""The form in which all of it lies before the friction, and the links' masses swing on it."""
UPSTREAM = Parameter(
    "upstream", "1", (0.0, 1.0), "share of the stretch that lies between gearbox and friction", typical=0.5,
    shared=True, optional=True, scan=(0.2, 0.5, 1.0),
    untold="Whether it gives way behind its friction, as model.yaml has it, or before it, these data do not "
    "tell: for that a load has to change, as other joints move, while this motor stands.",
)  # fmt: skip


class OnBothSides(Effect):
    """What stretches by a ``compliance``, or without end by a ``flow``. What lies before the friction moves
    the joint only where that slides: a load that changes within the dead band shows nothing of it.
    """

    @classmethod
    def options(cls, form: str) -> tuple[dict[str, float], ...]:
        """All of it on either side: a joint that sticks shows by when it moves which one it is."""
        return ({}, {UPSTREAM.name: 1.0}) if UPSTREAM in cls.own_parameters(form) else ({},)

    def upstream(self) -> Effect | None:
        return self if self.form == HELD else self._sides[0]

    def downstream(self) -> Effect | None:
        return None if self.form == HELD else self._sides[1]

    def transients(self, now: Now) -> Transients | None:
        links = Links.on_wires(self, now) if self.form == HELD else None
        return None if links is None else links.freed(now)

    def included(self, now: Now) -> Mapping[str, Array]:
        links = Links.on_wires(self, now)
        return {} if links is None else links.shown()

    @cached_property
    def _sides(self) -> tuple[Effect | None, Effect | None]:
        before = self["upstream"]
        if not np.any(before > 0.0):
            return None, self
        return self._share(before), None if np.all(before == 1.0) else self._share(1.0 - before)

    def _share(self, share: Array) -> Self:
        sizes = {name: share * self[name] for name in ("compliance", "flow") if name in self.values}
        return type(self)({**self.values, **sizes}, self.words, self.form)
